"""What a new SQLite database is made by: what all revisions leave, without Alembic.

Alembic and its revisions take a quarter of a second, which each first start would wait for. A test
compares; `python -m service.jobs.store.sql.migrations.snapshot` writes it anew after a revision.
"""

STATEMENTS = """\
CREATE TABLE IF NOT EXISTS alembic_version (
    version_num VARCHAR(32) NOT NULL,
    CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
CREATE TABLE IF NOT EXISTS api_keys (
    id VARCHAR(12) NOT NULL,
    name VARCHAR(64) NOT NULL,
    digest VARCHAR(64) NOT NULL,
    scopes VARCHAR(80) NOT NULL,
    created_at VARCHAR(40) NOT NULL,
    expires_at VARCHAR(40),
    revoked_at VARCHAR(40),
    PRIMARY KEY (id)
);
CREATE TABLE IF NOT EXISTS artifacts (
    digest VARCHAR(64) NOT NULL,
    content BLOB NOT NULL,
    parts TEXT NOT NULL,
    world_digest VARCHAR(80),
    stored_at VARCHAR(40) NOT NULL,
    PRIMARY KEY (digest)
);
CREATE TABLE IF NOT EXISTS job_bodies (
    job VARCHAR(64) NOT NULL,
    payload TEXT NOT NULL,
    result TEXT,
    failure TEXT,
    PRIMARY KEY (job)
);
CREATE TABLE IF NOT EXISTS job_events (
    job VARCHAR(64) NOT NULL,
    number INTEGER NOT NULL,
    type VARCHAR(64) NOT NULL,
    data TEXT NOT NULL,
    at VARCHAR(40) NOT NULL,
    PRIMARY KEY (job, number)
);
CREATE TABLE IF NOT EXISTS job_makers (
    job VARCHAR(64) NOT NULL,
    made_by TEXT NOT NULL,
    PRIMARY KEY (job)
);
CREATE TABLE IF NOT EXISTS job_owner (
    id INTEGER NOT NULL,
    epoch BIGINT NOT NULL,
    is_released BOOLEAN NOT NULL,
    PRIMARY KEY (id)
);
CREATE TABLE IF NOT EXISTS job_robots (
    job VARCHAR(64) NOT NULL,
    robot VARCHAR(256) NOT NULL,
    is_waiting BOOLEAN NOT NULL,
    PRIMARY KEY (job, robot)
);
CREATE TABLE IF NOT EXISTS "job_summaries" (
    job VARCHAR(64) NOT NULL,
    payload TEXT NOT NULL,
    result TEXT,
    failure TEXT,
    PRIMARY KEY (job)
);
CREATE TABLE IF NOT EXISTS jobs (
    sequence INTEGER NOT NULL,
    id VARCHAR(64) NOT NULL,
    queue VARCHAR(20) NOT NULL,
    task VARCHAR(200) NOT NULL,
    scene VARCHAR(64),
    world_digest VARCHAR(80),
    priority INTEGER NOT NULL,
    time_limit FLOAT,
    max_attempts INTEGER NOT NULL,
    attempts INTEGER NOT NULL,
    "key" VARCHAR(200),
    request_digest VARCHAR(64) NOT NULL,
    state VARCHAR(12) NOT NULL,
    stage VARCHAR(40) NOT NULL,
    progress FLOAT NOT NULL,
    is_cancel_requested BOOLEAN NOT NULL,
    num_events INTEGER NOT NULL,
    created_at VARCHAR(40) NOT NULL,
    started_at VARCHAR(40),
    finished_at VARCHAR(40), cancel_requested_at VARCHAR(40), batch VARCHAR(64), client
    VARCHAR(80) DEFAULT '' NOT NULL,
    PRIMARY KEY (sequence),
    UNIQUE (queue, "key"),
    UNIQUE (id)
);
CREATE TABLE IF NOT EXISTS scene_entries (
    scene VARCHAR(64) NOT NULL,
    number BIGINT NOT NULL,
    PRIMARY KEY (scene)
);
CREATE TABLE IF NOT EXISTS scene_states (
    scene VARCHAR(64) NOT NULL,
    robot VARCHAR(256) NOT NULL,
    positions TEXT NOT NULL,
    status VARCHAR(12) NOT NULL,
    revision INTEGER,
    execution VARCHAR(64),
    updated_at VARCHAR(40) NOT NULL,
    PRIMARY KEY (scene, robot)
);
CREATE TABLE IF NOT EXISTS scenes (
    serial INTEGER NOT NULL,
    id VARCHAR(64) NOT NULL,
    revision INTEGER NOT NULL,
    digest VARCHAR(64) NOT NULL,
    artifact VARCHAR(64) NOT NULL,
    name VARCHAR(256) NOT NULL,
    created_at VARCHAR(40) NOT NULL,
    summary JSON NOT NULL,
    "key" VARCHAR(200),
    request_digest VARCHAR(64),
    PRIMARY KEY (serial),
    UNIQUE (id, revision)
);
CREATE TABLE IF NOT EXISTS webhook_notices (
    sequence INTEGER NOT NULL,
    webhook VARCHAR(64) NOT NULL,
    job VARCHAR(64) NOT NULL,
    number INTEGER NOT NULL,
    attempts INTEGER NOT NULL,
    due_at VARCHAR(40) NOT NULL,
    PRIMARY KEY (sequence)
);
CREATE TABLE IF NOT EXISTS webhooks (
    sequence INTEGER NOT NULL,
    id VARCHAR(64) NOT NULL,
    url TEXT NOT NULL,
    secret VARCHAR(100) NOT NULL,
    events TEXT NOT NULL,
    created_at VARCHAR(40) NOT NULL,
    failing_since VARCHAR(40),
    disabled_at VARCHAR(40),
    reason VARCHAR(200) NOT NULL,
    PRIMARY KEY (sequence),
    UNIQUE (id)
);
CREATE INDEX ix_api_keys_name ON api_keys (name);
CREATE INDEX ix_artifacts_world_digest ON artifacts (world_digest);
CREATE INDEX ix_scenes_id ON scenes (id);
CREATE INDEX jobs_by_state ON jobs (queue, state, sequence);
CREATE INDEX jobs_of_batch ON jobs (batch, sequence);
CREATE INDEX jobs_of_content ON jobs (queue, world_digest, sequence);
CREATE INDEX jobs_of_queue ON jobs (queue, sequence);
CREATE INDEX jobs_of_scene ON jobs (queue, scene, sequence);
CREATE INDEX jobs_of_scene_by_state ON jobs (queue, scene, state, sequence);
CREATE INDEX robots_waited_for ON job_robots (is_waiting, job);
CREATE UNIQUE INDEX scenes_by_key ON scenes ("key");
CREATE INDEX scenes_by_revision ON scenes (revision, serial);
CREATE INDEX webhook_notices_by_time ON webhook_notices (due_at);
CREATE INDEX webhook_notices_of_job ON webhook_notices (webhook, job, sequence);
"""
