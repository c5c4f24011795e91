"""help_text(): what the page is, in a few lines for those who see it the first time."""

from html import escape

from service.studio import texts

_LINES = (
    ("Wayproof", "plans motions of robots, and proves that they hit nothing and keep all limits."),
    ("Choose a goal, Plan, Execute:", "the robot moves in simulation."),
    ("The view:", "drag to turn, right-drag to shift, wheel to come nearer."),
    ("Blue ghosts:", "where the robot will be: at the goal, or along the motion."),
    ("Red and gray ghosts:", "a pose that collides; other arm poses that reach the goal."),
    ("Ghosts in other colours:", "plans that are ticked in Plans; they move along."),
    ("Drag the goal:", "choose the goal 'drag the tool', then pull the arrows at the tool."),
    (
        "Proven:",
        "checked between its samples too, in one revision of the scene. An edit makes another.",
    ),
)


def help_text(server: str | None) -> str:
    """Return the lines as HTML.

    Args:
        server: URL of the server's pages; empty for that of the page, None if there are none.
    """
    lines = "".join(f"<p><b>{escape(head)}</b> {escape(rest)}</p>" for head, rest in _LINES)
    if server is None:
        return texts.boxed(lines)
    link = (
        f'<a href="{escape(server)}/docs" target="_blank" rel="noopener" '
        f'style="color:{texts.COLORS["busy"]}">The HTTP API behind it</a>'
    )
    return texts.boxed(f"{lines}<p>{link}</p>")
