"""Hostile requests, each with the answer that is right: a table, read by test_bodies.py.

Columns: what it is; method and path; headers; body (bytes as they are, else as JSON); the status,
the code, and a word of the detail. `{scene}` stands for a scene that is there.
"""

NAN, INF = float("nan"), float("inf")
YAML, JSON = {"content-type": "application/yaml"}, {"content-type": "application/json"}
ARM = {"name": "arm", "model": "ur5e"}


def scene(**fields):
    return {"name": "s", "robots": [ARM], **fields}


def plan(**fields):
    goal = {"type": "joint", "positions": [0.0] * 6}
    return {"scene": "{scene}", "group": "arm", "goal": goal, **fields}


def pose(*position, **fields):
    return plan(goal={"type": "pose", "poses": [{"position": list(position)}], **fields})


def text(body, code, word, status=422):
    """YAML that is posted as a scene."""
    return "POST /v1/scenes", YAML, body.encode(), status, code, word


def posted(document, word, code="scene_invalid"):
    """JSON that is posted as a scene."""
    return "POST /v1/scenes", JSON, document, 422, code, word


def asked(request, code, word, status=422):
    """A request for a plan."""
    return "POST /v1/plans", JSON, request, status, code, word


def sent(method_path, headers, body, status, code, word=""):
    return method_path, headers, body, status, code, word


TEMPLATE = "line 2: a key must be text, got a mapping; `{{ ... }}` is a template"
YAMLS = {
    "template": text("robots:\n - {name: {{ name }}, model: ur5e}", "scene_invalid", TEMPLATE),
    "template of all": text("{{ scene }}", "scene_invalid", "template"),
    "list as key": text("[a, b]: 1", "scene_invalid", "a key must be text, got a list"),
    "mapping as key": text("? {a: 1}\n: 2", "scene_invalid", "mapping"),
    "number as key": text("1: 2", "scene_invalid", "'1' is not text"),
    "null as key": text("null: 2", "scene_invalid", "'null' is not text"),
    "date as key": text("2020-01-01: 2", "scene_invalid", "not text"),
    "merge key": text("<<: {robots: []}", "scene_invalid", "'<<' is not text"),
    "key twice": text("robots: []\nrobots: []", "scene_invalid", "line 2: key 'robots' is given"),
    "alias": text("a: &a [1]\nb: *a", "scene_invalid", "line 2: aliases"),
    "python object": text("a: !!python/object:os.system x", "scene_invalid", "constructor"),
    "tag of a date": text("robots: !!timestamp xyz", "scene_invalid", "not of its tag"),
    "tag of a boolean": text("robots: !!bool xyz", "scene_invalid", "not of its tag"),
    "tag of a number": text("robots: !!int ''", "scene_invalid", "not of its tag"),
    "tag of a float": text("robots: !!float xyz", "scene_invalid", "not of its tag"),
    "tag of bytes": text("robots: !!binary abc", "scene_invalid", "base64"),
    "two documents": text("---\na: 1\n---\nb: 1", "scene_invalid", "another document"),
    "control character": text("a: \x00", "scene_invalid", "control characters"),
    "deep": text("[" * 100 + "]" * 100, "scene_invalid", "too large"),
    "nothing": text("", "scene_invalid", "must be a mapping"),
    "a list": text("- a", "scene_invalid", "must be a mapping"),
    "tabs": text("a:\n\t- b", "scene_invalid", "line 2"),
    "version": text("%YAML 9.9\n---\na: 1", "scene_invalid", "line 1"),
}

SCENES = {
    "misspelt field": posted(scene(object=[]), "did you mean 'objects'?"),
    "misspelt field of a robot": posted(
        {"robots": [{**ARM, "bse": {}}]}, "robots.0.bse: field 'bse' does not exist; did you mean"
    ),
    "misspelt field of an object": posted(
        scene(objects=[{"name": "a", "shap": {"sphere": 1}}]), "did you mean 'shape'?"
    ),
    "NaN among positions": posted(
        {"robots": [{**ARM, "positions": [0, NAN, 0, 0, 0, 0]}]}, "robots.0.positions.1: "
    ),
    "NaN by joint": posted(
        {"robots": [{**ARM, "positions": {"elbow_joint": NAN}}]}, "positions.elbow_joint: "
    ),
    "infinite margin": posted(scene(margin=INF), "margin"),
    "name of a path": posted({"robots": [{**ARM, "name": "../arm"}]}, "robots.0.name"),
    "name with a scope": posted({"robots": [{**ARM, "name": "a::b"}]}, "robots.0.name"),
    "robot of a path upwards": posted(
        {"robots": [{**ARM, "model": "../../ur5e"}]}, "not a robot description", "asset_not_found"
    ),
    "robot of a NUL": posted(
        {"robots": [{**ARM, "model": "/a\0b.urdf"}]}, "there is no file", "asset_not_found"
    ),
    "robot of a folder": posted(
        {"robots": [{**ARM, "model": "/"}]}, "not a robot description", "asset_not_found"
    ),
    "mesh of a NUL": posted(
        scene(objects=[{"name": "a", "shape": {"mesh": {"uri": "/a\0.obj"}}}]), "there is no file"
    ),
    "mesh of a device": posted(
        scene(objects=[{"name": "a", "shape": {"mesh": {"uri": "/dev/zero"}}}]), "there is no file"
    ),
    "points in a plane": posted(
        scene(objects=[{"name": "a", "shape": {"convex": {"points": [[0, 0, 0]] * 4}}}]), "coplanar"
    ),
    "huge numbers": posted(scene(objects=[{"name": "a", "shape": {"sphere": 1e300}}]), "sphere"),
    "robots in excess": posted({"robots": [ARM] * 65}, "64"),
    "robots as an object": posted({"robots": {"arm": ARM}}, "list"),
    "nothing at all": posted({}, "robots"),
}

REQUESTS = {
    "NaN in a goal": asked(
        plan(goal={"type": "joint", "positions": [0, 0, NAN, 0, 0, 0]}),
        "request_invalid",
        "body.goal.positions.2: Input should be a finite number",
    ),
    "NaN in one of several": asked(
        plan(goal={"type": "joint", "positions": [[0] * 6, [0, 0, 0, NAN, 0, 0]]}),
        "request_invalid",
        "body.goal.positions.1.3: Input should be a finite number",
    ),
    "NaN in a pose": asked(pose(0, NAN, 0), "request_invalid", "goal.poses.0.position.1"),
    "infinite start": asked(plan(start=[INF] * 6), "request_invalid", "start.0"),
    "misspelt field of a goal": asked(
        pose(0, 0, 0, aproach=[0, 0, 1]), "request_invalid", "did you mean 'approach'?"
    ),
    "misspelt field inside": asked(
        plan(retime={"metod": "toppra"}), "request_invalid", "did you mean 'method'?"
    ),
    "misspelt field outside": asked(plan(sed=3), "request_invalid", "did you mean 'seed'?"),
    "misspelt goal": asked(plan(goal={"type": "poze"}), "request_invalid", "body.goal"),
    "goal of a list": asked(plan(goal=[]), "request_invalid", "body.goal"),
    "seed of a float": asked(plan(seed=1.5), "request_invalid", "seed"),
    "seed below zero": asked(plan(seed=-1), "request_invalid", "seed"),
    "seed in excess": asked(plan(seed=2**32), "request_invalid", "seed"),
    "huge integer": asked(b'{"seed": ' + b"9" * 5000 + b"}", "unreadable_body", "not JSON", 400),
    "key twice": asked(b'{"scene": "a", "scene": "b"}', "request_invalid", "body.scene: key"),
    "key twice inside": asked(
        b'{"goal": {"type": "pose", "type": "joint"}}', "request_invalid", "body.goal.type: key"
    ),
    "key twice in what is replaced": asked(
        b'{"goal": {"a": 1, "a": 2}, "goal": 1}', "request_invalid", "given twice"
    ),
    "lone surrogate": asked(plan(group="\ud800"), "request_invalid", "group"),
    "group of a NUL": asked(plan(group="a\0b"), "unknown_name", "does not exist", 422),
    "long name": asked(plan(group="g" * 1025), "request_invalid", "group"),
    "endless time": asked(
        plan(search={"allowed_planning_time": INF}), "request_invalid", "allowed_planning_time"
    ),
    "velocities of next to nothing": asked(
        plan(retime={"velocity_scale": 1e-160}), "request_invalid", "retime.velocity_scale"
    ),
    "accelerations of next to nothing": asked(
        plan(retime={"method": "ruckig", "acceleration_scale": 1e-20}),
        "request_invalid",
        "body.retime.acceleration_scale: Input should be greater than or equal to 0.000000001",
    ),
    "scene of a path": asked(plan(scene="../x"), "not_found", "scene", 404),
}

CHECK = "POST /v1/scenes/{scene}/check"
HTTP = {
    "text": sent("POST /v1/plans", {"content-type": "text/plain"}, b"{}", 415,
                 "unsupported_media_type", "text/plain"),
    "form": sent("POST /v1/plans", {"content-type": "application/x-www-form-urlencoded"}, b"a=1",
                 415, "unsupported_media_type"),
    "multipart": sent("POST /v1/plans", {"content-type": "multipart/form-data; boundary=x"},
                      b"--x--", 415, "unsupported_media_type"),
    "no type": sent("POST /v1/plans", {}, b"{}", 415, "unsupported_media_type"),
    "nonsense as a type": sent("POST /v1/plans", {"content-type": ";;;"}, b"{}", 415,
                               "unsupported_media_type"),
    "text for a check": sent(CHECK, {"content-type": "text/plain"}, b"{}", 415,
                             "unsupported_media_type"),
    "YAML for an edit": sent("PATCH /v1/scenes/{scene}", YAML, b"operations: []", 415,
                             "unsupported_media_type"),
    "text for a scene": sent("POST /v1/scenes", {"content-type": "text/plain"}, b"{}", 415,
                             "unsupported_media_type"),
    "XML for a scene": sent("POST /v1/scenes", {"content-type": "application/xml"}, b"<a/>", 415,
                            "unsupported_media_type"),
    "broken JSON": sent("POST /v1/plans", JSON, b"{", 400, "unreadable_body"),
    "not UTF-8": sent("POST /v1/plans", JSON, b'{"a": "\xff"}', 400, "unreadable_body"),
    "deep JSON": sent(CHECK, JSON, b"[" * 100_000, 400, "unreadable_body"),
    "deep scene": sent("POST /v1/scenes", JSON, b"[" * 100_000, 400, "unreadable_body"),
    "key twice in a scene": sent("POST /v1/scenes", JSON, b'{"robots": [], "robots": []}', 422,
                                 "scene_invalid", "robots: key 'robots' is given twice"),
    "key twice in an edit": sent("PATCH /v1/scenes/{scene}", JSON, b'{"revision":1,"revision":2}',
                                 422, "request_invalid", "given twice"),
    "parameter twice": sent("GET /v1/plans?limit=1&limit=2", {}, None, 422, "request_invalid",
                            "query.limit: it is given twice"),
    "parameter of another": sent("GET /v1/plans?limt=1", {}, None, 422, "unknown_name",
                                 "did you mean 'limit'?"),
    "limit of a word": sent("GET /v1/plans?limit=x", {}, None, 422, "request_invalid",
                            "query.limit"),
    "wait of NaN": sent("POST /v1/plans?wait=nan", JSON, plan(), 422, "request_invalid",
                        "query.wait"),
    "cursor beyond": sent("GET /v1/plans?cursor=" + "9" * 30, {}, None, 422, "request_invalid",
                          "query.cursor"),
    "another host": sent("GET /v1/plans", {"host": "evil.example"}, None, 400, "host_not_allowed",
                         "evil.example"),
    "another host with our port": sent("GET /healthz", {"host": "evil.example:8470"}, None, 400,
                                       "host_not_allowed"),
    "host that begins like ours": sent("GET /healthz", {"host": "localhost.evil.example"}, None,
                                       400, "host_not_allowed"),
    "no host": sent("GET /healthz", {"host": ""}, None, 400, "host_not_allowed"),
    "page of another origin": sent("POST /v1/plans", {**JSON, "origin": "http://evil.example"},
                                   plan(), 403, "origin_not_allowed", "evil.example"),
    "page of no origin": sent("POST /v1/plans", {**JSON, "origin": "null"}, plan(), 403,
                              "origin_not_allowed"),
    "page of another port": sent("POST /v1/plans", {**JSON, "origin": "http://testserver:1"},
                                 plan(), 403, "origin_not_allowed"),
    "cancel by a page": sent("POST /v1/plans/pln_1/cancel", {"origin": "http://evil.example"},
                             None, 403, "origin_not_allowed"),
    "path upwards": sent("GET /v1/scenes/..%2f..%2fetc%2fpasswd", {}, None, 404, "not_found"),
    "id of a NUL": sent("GET /v1/plans/pln_%00", {}, None, 404, "not_found"),
    "method of no use": sent("PUT /v1/plans", JSON, {}, 405, "method_not_allowed"),
    "small body in excess": sent(CHECK, JSON, b" " * (4 * 2**20 + 1), 413, "body_too_large"),
    "YAML in excess": sent("POST /v1/scenes", YAML, b"# \n" * 700_000, 413, "body_too_large"),
    "check of NaN": sent(CHECK, JSON, {"group": "arm", "configurations": [[NAN] * 6]}, 422,
                         "request_invalid", "configurations.0.0"),
    "check of more than there is time for": sent(
        CHECK, JSON, {"group": "arm", "configurations": [[0.0] * 6] * 2_001}, 422,
        "request_invalid", "configurations: List should have at most 2000 items",
    ),
    "waypoint that no joint reaches": sent(
        "POST /v1/trajectories/retime", JSON,
        {"scene": "{scene}", "group": "arm", "waypoints": [[1e6] + [0.0] * 5, [0.0] * 6]}, 422,
        "problem_invalid", "waypoints.0: arm::shoulder_pan_joint = 1e+06 is not in [-6.28319, 6.2",
    ),
    "edit that is misspelt": sent(
        "PATCH /v1/scenes/{scene}", JSON, {"operations": [{"op": "mve", "object": "a"}]}, 422,
        "request_invalid", "operations.0",
    ),
}  # fmt: skip

TABLES = {"yaml": YAMLS, "scene": SCENES, "request": REQUESTS, "http": HTTP}
CASES = {f"{kind}: {name}": row for kind, rows in TABLES.items() for name, row in rows.items()}
