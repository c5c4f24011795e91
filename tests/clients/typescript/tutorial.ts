// The steps of docs/tutorial/first-motion.md, by types that `openapi-typescript` has generated and `openapi-fetch`.
// Called with the server's address and the scene's file; prints what it found as JSON.

import { readFile } from "node:fs/promises";
import { EventSourceParserStream } from "eventsource-parser/stream";
import createClient from "openapi-fetch";
import type { components, paths } from "./wayproof.js";

type Schemas = components["schemas"];
type Goal = Schemas["PoseGoal"];

const [url = "", sceneFile = ""] = process.argv.slice(2);
// A server that asks for no keys does not look at it.
const key = process.env["WAYPROOF_API_KEY"] ?? "none";
const client = createClient<paths>({ baseUrl: url, headers: { Authorization: `Bearer ${key}` } });

/** Return the data of an answer, or throw its problem document. */
function given<Data>(answer: { data?: Data; error?: { detail: string } }): Data {
  if (answer.data === undefined) throw new Error(answer.error?.detail ?? "no answer");
  return answer.data;
}

/** Yield the events of a stream, typed as the document has them. */
async function* events<Event>(answer: {
  data?: ReadableStream<Uint8Array<ArrayBuffer>> | null;
}): AsyncGenerator<Event> {
  if (!answer.data) throw new Error("no stream");
  const told = answer.data
    .pipeThrough(new TextDecoderStream())
    .pipeThrough(new EventSourceParserStream());
  for await (const event of told) yield event as Event;
}

const scene = given(
  await client.POST("/v1/scenes", {
    // YAML goes as it is: the document says that this body is a text
    body: await readFile(sceneFile, "utf8"),
    bodySerializer: (text) => text as string,
    headers: { "Content-Type": "application/yaml" },
  }),
);
const arm = scene.groups[0]!;

const listed: Record<string, string[]> = {};
for (const name of given(await client.GET("/v1/models")).items) {
  const model = given(await client.GET("/v1/models/{name}", { params: { path: { name } } }));
  listed[name] = model.groups[0]!.joints.map((joint) => joint.name);
}

const inScene = { params: { path: { scene: scene.id } } };
const verdicts = given(
  await client.POST("/v1/scenes/{scene}/check", {
    ...inScene,
    body: { group: arm.name, configurations: [arm.positions] },
  }),
);
const goal: Goal = {
  type: "pose",
  poses: [{ position: [0, 0, 0], frame: "pick" }],
  frame: "arm::tcp",
};
const solved = given(
  await client.POST("/v1/scenes/{scene}/ik", { ...inScene, body: { group: "arm", goal } }),
);

const request: Schemas["PlanRequest"] = { scene: scene.id, group: "arm", seed: 7, goal };
const plan = given(
  await client.POST("/v1/plans", { params: { query: { wait: 60 } }, body: request }),
);
if (plan.result === null) throw new Error(plan.failure?.code);
const certificate = plan.result.certificate; // absent only where `include` leaves it out
if (certificate === undefined) throw new Error("no certificate");
const path = { plan: plan.id };
const samples = given(
  await client.GET("/v1/plans/{plan}/trajectory", { params: { path, query: { period: 0.01 } } }),
);
// The formats' types differ: JSON is what was asked for.
if (typeof samples === "string" || !("duration" in samples)) throw new Error("no JSON");
const page = given(
  await client.GET("/v1/plans/{plan}/replay.html", { params: { path }, parseAs: "text" }),
);

const stages: string[] = [];
const ofPlan = await client.GET("/v1/plans/{plan}/events", { params: { path }, parseAs: "stream" });
for await (const event of events<Schemas["JobEvent"]>(ofPlan)) {
  if (event.event === "stage") {
    const data: Schemas["StageData"] = JSON.parse(event.data);
    stages.push(data.stage);
  }
}

const begun = given(
  await client.POST("/v1/executions", {
    body: { plan: plan.id, driver: "simulated", speed: 10, title: "to the can" },
  }),
);
const execution = { params: { path: { execution: begun.id } } };
const ofExecution = await client.GET("/v1/executions/{execution}/events", {
  ...execution,
  parseAs: "stream",
});
let end: Schemas["FinishedData"] | undefined;
for await (const event of events<Schemas["ExecutionEvent"]>(ofExecution)) {
  if (event.event === "finished") end = JSON.parse(event.data);
}
const moved = given(await client.GET("/v1/executions/{execution}", execution));
if (end?.state !== "succeeded") throw new Error(`${end?.state}, ${moved.failure?.detail}`);
const executed = given(
  await client.GET("/v1/scenes/{scene}/replay.html", { ...inScene, parseAs: "text" }),
);

const misspelt = await client.POST("/v1/plans", { body: { ...request, group: "amr" } });
// The code narrows the evidence.
if (misspelt.error?.code !== "unknown_name") throw new Error("not refused");
const kind: string = misspelt.error.evidence.kind;
const missing = await client.POST("/v1/scenes/{scene}/check", {
  params: { path: { scene: "scn_0" } },
  body: { group: "arm", configurations: [[0]] },
});

console.log(
  JSON.stringify({
    models: listed,
    valid: verdicts.results[0]!.valid,
    num_configurations: solved.configurations.length,
    clearance: solved.configurations[0]!.clearance,
    proven: certificate.proven,
    duration: samples.duration,
    last_time: samples.times.at(-1),
    stages,
    execution: moved.state,
    replays: [page.length, executed.length],
    refusals: [misspelt.error.detail, missing.error?.detail],
    kind,
  }),
);
