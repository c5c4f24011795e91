"""The body of a posted scene: which language it is in, and its text."""

from typing import Literal

from fastapi import Request

from service.api.strict_route import kind_of
from service.errors import BodyTooLarge, UnreadableBody, UnsupportedMediaType

type Media = Literal["json", "yaml"]

YAML_TYPES = ("application/yaml", "application/x-yaml", "text/yaml", "text/x-yaml")
# YAML is for what people write; libyaml needs seconds for what machines do.
MAX_YAML_BYTES = 2_000_000


async def read_scene_body(request: Request) -> tuple[str, Media]:
    """Return the text of a scene and its language.

    Raises:
        UnsupportedMediaType: The content type is neither JSON nor YAML.
        BodyTooLarge: It is YAML, and long.
        UnreadableBody: It is not UTF-8.
    """
    media = media_of(request.headers.get("content-type", "application/json"))
    body = await request.body()
    if media == "yaml" and len(body) > MAX_YAML_BYTES:
        message = f"{len(body)} bytes of YAML; at most {MAX_YAML_BYTES} are read, post JSON instead"
        raise BodyTooLarge(message, {"bytes": len(body), "bound": MAX_YAML_BYTES})
    try:
        return body.decode("utf-8"), media
    except UnicodeDecodeError as fault:
        message = f"the body is not UTF-8: {fault.reason} at byte {fault.start}"
        raise UnreadableBody(message, {"position": fault.start}) from fault


def media_of(content_type: str) -> Media:
    """Return the language that a content type stands for.

    Raises:
        UnsupportedMediaType: None that is read here.
    """
    kind = kind_of(content_type)
    if kind == "application/json" or kind.endswith("+json"):
        return "json"
    if kind in YAML_TYPES or kind.endswith("+yaml"):
        return "yaml"
    known = ["application/json", *YAML_TYPES]
    detail = f"scenes are read as {' or '.join(known)}, not {kind}"
    raise UnsupportedMediaType(detail, {"got": kind, "known": known})
