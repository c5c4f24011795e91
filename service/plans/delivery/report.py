"""report_html(): a plan as a page for printing: request, certificate, pictures, charts."""

import json
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from service.plans.models.plan import PlanSummary
from service.plans.tasks import MotionPictures

# In this order, of a plan that succeeded.
CHARTS = ("position", "velocity", "acceleration", "torque", "clearance", "utilisation")

_STYLE = """
body { font: 14px/1.45 system-ui, sans-serif; color: #1b2733; max-width: 62rem; margin: 2rem auto;
  padding: 0 1.5rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.1rem; margin-top: 2rem; border-bottom: 1px solid #ccd; }
table { border-collapse: collapse; width: 100%; }
th { white-space: nowrap; }
th, td { text-align: left; padding: 3px 10px 3px 0;
  border-bottom: 1px solid #e4e8ec; vertical-align: top; overflow-wrap: anywhere; }
td.number { font-variant-numeric: tabular-nums; } .yes { color: #1d7a3a; } .no { color: #b03a2e; }
pre { background: #f5f7f9; padding: 10px; white-space: pre-wrap; overflow-wrap: anywhere; }
figure { margin: 1rem 0; break-inside: avoid; } figure svg { width: 100%; height: auto; }
.pictures { display: grid; grid-template-columns: repeat(3, 1fr); gap: 0.8rem; }
.pictures figure { margin: 0; } .pictures img { width: 100%; border: 1px solid #e4e8ec; }
figcaption { font-size: 12px; color: #52606d; overflow-wrap: anywhere; }
@media print {
  body { margin: 0; max-width: none; } nav { display: none; } tr { break-inside: avoid; }
}
"""


def report_html(
    plan: PlanSummary,
    result: Mapping[str, Any],
    charts: Mapping[str, str],
    pictures: MotionPictures | None,
) -> str:
    """Return a page that loads nothing and runs nothing.

    Args:
        plan: The plan, ended.
        result: Of a plan that succeeded, as clients are given it; else empty.
        charts: Drawings (SVG) by name.
        pictures: Of the motion in its scene, of a plan that failed none; None if there was not
            enough time to draw them.
    """
    certificate = result.get("certificate") or {}
    plain = plan.model_dump(mode="json")
    parts = [
        _verdict(plan, certificate),
        _pictures(pictures),
        _section("Summary", _table(_facts(plain, result))),
        _failure(plain["failure"]),
        _certificate(certificate),
        *(f"<figure>{_inline(svg)}</figure>" for svg in charts.values()),
        _section("Request", _json(plain["request"])),
        _section("Seconds per stage", _table(plain["timings"].items())),
        _section("Versions", _table(plain["versions"].items())),
    ]
    title = escape(f"Plan {plan.id}")
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{_STYLE}</style></head><body><h1>{title}</h1>{_links(plan)}"
        f"{''.join(parts)}</body></html>\n"
    )


def _links(plan: PlanSummary) -> str:
    """Return links to what else there is, for the screen."""
    is_solved = plan.state == "succeeded"
    view = "replay.html" if is_solved else "failure.html"
    return f'<nav><a href="{view}">3-D view</a> · <a href="bundle.zip">bundle.zip</a></nav>'


def _verdict(plan: PlanSummary, certificate: Mapping[str, Any]) -> str:
    if certificate:
        proven = certificate["proven"]
        word = "proven" if proven else "not proven"
        return f'<p class="{"yes" if proven else "no"}"><strong>{word}</strong></p>'
    return f'<p class="no"><strong>{escape(str(plan.state))}</strong></p>'


def _pictures(pictures: MotionPictures | None) -> str:
    """Return the pictures beside each other, in the page itself."""
    if pictures is None:
        return "<p>There was not enough time to draw pictures of the motion.</p>"
    shown = "".join(
        f'<figure><img alt="{escape(caption)}" src="data:image/png;base64,{content}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for caption, content in zip(pictures.captions, pictures.base64, strict=True)
    )
    return f'<div class="pictures">{shown}</div>' if shown else ""


def _facts(plan: Mapping[str, Any], result: Mapping[str, Any]) -> list[tuple[str, Any]]:
    request = plan["request"]
    certificate, trajectory = result.get("certificate") or {}, result.get("trajectory") or {}
    facts = [
        ("scene", f"{request['scene']}, revision {request.get('revision')}"),
        ("group", request["group"]),
        ("state", plan["state"]),
        ("seed", plan["seed"]),
        ("digest", plan["digest"]),
        ("duration [s]", trajectory.get("duration")),
        ("proven clearance [m]", certificate.get("min_clearance")),
        ("nearest pair", " and ".join(filter(None, certificate.get("pair") or ()))),
        ("requested", plan["created_at"]),
        ("finished", plan["finished_at"]),
    ]
    return [(name, value) for name, value in facts if value not in {None, ""}]


def _failure(failure: Mapping[str, Any] | None) -> str:
    if failure is None:
        return ""
    rows = [(name, failure.get(name)) for name in ("code", "stage", "detail")]
    return _section("Failure", _table(rows) + _json(failure.get("evidence") or {}))


def _certificate(certificate: Mapping[str, Any]) -> str:
    if not certificate:
        return ""
    head = ("check", "value", "bound", "unit", "looked at every", "passed")
    rows = [
        (
            " ".join(filter(None, (check["name"], check.get("where")))),
            _number(check["value"]),
            _number(check["bound"]),
            check["unit"],
            _number(check["resolution"] or None) or "all of it",
            "yes" if check["passed"] else "NO",
        )
        for check in certificate["checks"]
    ]
    unchecked = [
        (" and ".join(pair["bodies"]), pair.get("reason", ""))
        for pair in certificate.get("unchecked") or ()
    ]
    told = _rows(("pair of bodies", "why it is not checked"), unchecked) if unchecked else ""
    return _section("Certificate", _rows(head, rows) + told)


def _section(title: str, content: str) -> str:
    return f"<h2>{escape(title)}</h2>{content}"


def _table(rows: Iterable[tuple[str, Any]]) -> str:
    told = "".join(
        f"<tr><th>{escape(str(name))}</th><td>{escape(_text(value))}</td></tr>"
        for name, value in rows
    )
    return f"<table>{told}</table>"


def _rows(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    names = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows
    )
    return f"<table><tr>{names}</tr>{body}</table>"


def _text(value: Any) -> str:
    return _number(value) if isinstance(value, float) else str(value)


def _number(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, (int, float)) else str(value)


def _json(content: Any) -> str:
    return f"<pre>{escape(json.dumps(content, indent=1))}</pre>"


def _inline(svg: str) -> str:
    """Return a drawing without the head of an XML file, as a page takes it."""
    return svg[svg.index("<svg") :]
