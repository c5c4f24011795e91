"""Settings: what an operator may choose: by arguments, `WAYPROOF_*` in the environment, a file."""

import ipaddress
import os
import tomllib
from collections.abc import Mapping
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, Self, override

from pydantic import Field, field_validator, model_validator
from pydantic_settings import (
    BaseSettings,
    InitSettingsSource,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    SettingsError,
)

from service.defaults import (
    GIB,
    default_data_dir,
    default_plan_slots,
    default_query_slots,
    default_worker_memory,
)
from service.telemetry.logs import LogFormat, LogLevel, LogTerms, usual_format

PREFIX = "WAYPROOF_"
# Names a file of settings.
CONFIG_FILE = "WAYPROOF_CONFIG_FILE"
_TEST_HOSTS = {"inline": ("testserver",)}


def read_config_file(environment: Mapping[str, str]) -> dict[str, Any]:
    """Return what the file of settings says, by their names; nothing if none is named.

    Raises:
        SettingsError: It cannot be read, or is not TOML.
    """
    named = environment.get(CONFIG_FILE)
    if not named:
        return {}
    try:
        return tomllib.loads(Path(named).read_text(encoding="utf-8"))
    except OSError as fault:
        message = f"{CONFIG_FILE}: cannot read {named}: {fault.strerror or fault}"
    except ValueError as fault:
        message = f"{CONFIG_FILE}: {named} is not TOML: {fault}"
    raise SettingsError(message)


class Settings(BaseSettings):
    """How this server runs. Frozen: a running server does not change its mind."""

    model_config = SettingsConfigDict(env_prefix=PREFIX, frozen=True, extra="forbid")

    host: str = Field(default="127.0.0.1", description="Address to listen on")
    port: int = Field(default=8470, ge=0, le=65535, description="Port; 0 for a free one")
    data_dir: Path = Field(default_factory=default_data_dir, description="Where records are kept")
    database_url: str | None = Field(
        default=None, description="SQLAlchemy URL; null for SQLite in the data folder"
    )
    engine: Literal["process", "ray", "inline"] = Field(
        default="process",
        description="Killable worker processes of this machine, or of the machines of a Ray "
        "cluster, or this process (for tests)",
    )
    ray_address: str | None = Field(
        default=None,
        pattern=r"^[^\s/]+:\d+$",
        description="Of the head of the Ray cluster, `host:port`, of which this machine is a node",
    )
    ray_hosts: int = Field(
        default=1,
        ge=1,
        le=256,
        description="Machines of the cluster that work at once, each with the slots below",
    )
    plan_slots: int = Field(
        default_factory=default_plan_slots,
        ge=1,
        le=256,
        description="Plans that may run at once",
    )
    search_processes: int = Field(
        default_factory=lambda: os.cpu_count() or 1,
        ge=1,
        le=256,
        description="How many processes may search at once, running plans included: what they "
        "leave idle makes the attempts of one plan side by side; 1 for one after another",
    )
    query_slots: int = Field(
        default_factory=default_query_slots,
        ge=1,
        le=64,
        description="Questions that may run at once; one more worker is kept for short ones",
    )
    regions_slots: int = Field(
        default=1, ge=1, le=64, description="Growths of regions that may run at once"
    )
    execution_slots: int = Field(
        default=2, ge=1, le=64, description="Executions that may run at once"
    )
    niceness: int = Field(
        default=10,
        ge=0,
        le=19,
        description="How far plans and questions let executions and the server go before (nice)",
    )
    worker_memory: int = Field(
        default_factory=default_worker_memory,
        ge=GIB // 2,
        description="What one worker may use [bytes]; what needs more fails",
    )
    max_queued: int = Field(
        default=1000,
        ge=1,
        description="Jobs that may wait, per queue; the last tenth is for clients of which none "
        "waits",
    )
    retention_days: float = Field(
        default=30.0,
        ge=0,
        description="How long plans, regions and executions are kept once they have ended "
        "[days]; 0 for all time",
    )
    model_roots: tuple[Path, ...] = Field(default=(), description="More folders of robots")
    allow_model_paths: bool | None = Field(
        default=None,
        description="Whether scenes may name robot and mesh files by path; null for only if the "
        "server listens on a loopback address",
    )
    allowed_hosts: tuple[str, ...] | None = Field(
        default=None,
        description="Names that requests may know the server by (`Host`), `*.example.org` for all "
        "below one; null for this machine's own names on a loopback address, else for any",
    )
    auth: Literal["none", "keys", "proxy"] = Field(
        default="none",
        description="Whether requests need an API key; none is for loopback only, proxy says that "
        "nothing but a proxy that authenticates can reach the server",
    )
    oidc_issuer: str | None = Field(
        default=None,
        pattern=r"^(https://|http://(localhost|127\.0\.0\.1|\[::1\])[:/])\S+$",
        description="Identity provider whose tokens are let in besides keys (OpenID Connect), as "
        "their `iss` says it; null for none. Needs the extra `oidc`",
    )
    oidc_audience: str | None = Field(
        default=None, min_length=1, description="Whom its tokens are meant for, as `aud` says it"
    )
    rate_limit: str = Field(
        default="",
        description="How many requests a key, or an address without one, may make: 600/minute; "
        "nothing for any number",
    )
    allowed_origins: tuple[str, ...] = Field(
        default=(),
        description="Web pages of other origins that may ask, such as `https://ui.example.org`",
    )
    studio: bool = Field(
        default=True,
        description="Whether the server has a page to look at scenes and to plan in, at `/`. Needs "
        "the extra `studio`",
    )
    header_timeout: float = Field(
        default=10.0, gt=0, description="Within which the headers of a request arrive [s]"
    )
    body_timeout: float = Field(
        default=60.0, gt=0, description="Within which the body of a request arrives [s]"
    )
    max_connections: int = Field(
        default=1000, ge=1, description="Open connections; the one that says least makes room"
    )
    max_body_bytes: int = Field(
        default=32 * 1024 * 1024, ge=1024, description="Longest body of a posted scene [bytes]"
    )
    max_wait: float = Field(default=60.0, gt=0, description="Longest `?wait=` [s]")
    query_timeout: float = Field(
        default=60.0, gt=0, description="For checks, IK and so on, once they run [s]"
    )
    queue_timeout: float = Field(
        default=30.0, gt=0, description="How long a question may wait for a worker [s]"
    )
    best_grace: float = Field(
        default=0.9,
        gt=0,
        description="How long a canceled plan may time and prove its best path so far [s]",
    )
    drain_seconds: float = Field(
        default=5.0,
        ge=0,
        description="For plans and regions that run to end before the server does, once it is "
        "told to [s]; the next server begins anew what does not",
    )
    otlp_endpoint: str | None = Field(
        default=None,
        description="Collector that gets traces (OTLP over HTTP), such as `http://localhost:4318`; "
        "null for none. Needs the extra `telemetry`",
    )
    log_format: LogFormat | None = Field(
        default=None, description="Of a line of the log; null for text on a terminal, else json"
    )
    log_level: LogLevel = Field(
        default="warning", description="What is logged at least; info has a line for each request"
    )

    @classmethod
    @override
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        env_settings: PydanticBaseSettingsSource,
        *_: PydanticBaseSettingsSource,
        **__: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Arguments win over the environment, and that over the file that it names."""
        in_file = InitSettingsSource(settings_cls, read_config_file(os.environ))
        return init_settings, env_settings, in_file

    webhook_private_addresses: bool = Field(
        default=False,
        description="Whether webhooks may lead to loopback and private addresses, which the world "
        "does not reach but this server does",
    )
    webhook_failure_days: float = Field(
        default=5.0, gt=0, description="After which a webhook that takes nothing is disabled [days]"
    )

    @model_validator(mode="after")
    def _has_cluster(self) -> Self:
        if self.engine == "ray" and self.ray_address is None:
            message = "the engine ray needs ray_address, the head of its cluster (host:port)"
            raise ValueError(message)
        if self.engine == "ray" and find_spec("ray") is None:
            message = "the engine ray needs the extra `ray`: pip install 'wayproof[ray]'"
            raise ValueError(message)
        return self

    @model_validator(mode="after")
    def _has_provider(self) -> Self:
        if self.oidc_issuer is None:
            return self
        if self.auth != "keys" or self.oidc_audience is None:
            message = "oidc_issuer needs auth=keys, and oidc_audience, which its tokens name"
            raise ValueError(message)
        if find_spec("jwt") is None:
            message = "oidc_issuer needs the extra `oidc`: pip install 'wayproof[oidc]'"
            raise ValueError(message)
        return self

    @field_validator("rate_limit")
    @classmethod
    def _parse_rate_limit(cls, text: str) -> str:
        from limits import parse  # noqa: PLC0415  (few servers have one)

        try:
            if text:
                parse(text)
        except ValueError as fault:
            message = f"{text!r} is no limit, such as 600/minute"
            raise ValueError(message) from fault
        return text

    @property
    def url(self) -> str:
        """The database's URL."""
        return self.database_url or f"sqlite:///{self.data_dir / 'wayproof.sqlite'}"

    @cached_property
    def folder(self) -> Path:
        """The data folder, links followed: it is the same for workers."""
        return self.data_dir.resolve()

    @property
    def owner(self) -> str:
        """What tells the database of a data folder from another one; no password is in it."""
        if self.database_url is None:
            return "the data folder"
        return self.database_url.rpartition("@")[2]

    @cached_property
    def logs(self) -> LogTerms:
        """How the server and its workers log."""
        return LogTerms(self.log_format or usual_format(), self.log_level)

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can reach the server."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names that requests may know the server by, in `Host`'s form."""
        if self.allowed_hosts is not None:
            return self.allowed_hosts
        if not self.is_loopback:
            return ("*",)
        own = f"[{self.host}]" if ":" in self.host else self.host
        # The last is what starlette's test client says, which has no server to name.
        return ("localhost", "127.0.0.1", "[::1]", own, *_TEST_HOSTS.get(self.engine, ()))

    @property
    def may_load_paths(self) -> bool:
        """Whether scenes may name files by path."""
        return self.is_loopback if self.allow_model_paths is None else self.allow_model_paths
