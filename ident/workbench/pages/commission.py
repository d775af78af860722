"""Put one joint into service: jog it while a button is held, let it search its zero, check its sign and scale."""

from collections.abc import Callable, Mapping

from nicegui import ui

from ident.workbench.pages.forms import as_word, keep_fields
from ident.workbench.pages.live import run_summary
from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.programs.recording_process import RunStatus

_OPTIONS = ("--rig", "--sim", "--pace")
"""Options of a recording that the commands for one joint have, too."""
_HINT = "Hold the button, or the space bar on it: the joint moves slowly until you release it."
_QUESTIONS = {
    "home": "Joint {} will search its zero by itself, as its drive's homing method says. Is the way free?",
    "axis-check": "Joint {} will swing by 0.05 {} to both sides of where it stands. Is the way free?",
}

HOLD_SCRIPT = """<script>
    // Hold-to-run: events while a control is held. They end with the hold, and with the page or its connection.
    (() => {
        let held = null, timer = 0;
        const tell = name => held.dispatchEvent(new CustomEvent(name));
        const control = event => event.target.closest?.("[data-hold]");
        const press = pressed => {
            if (held) return;
            held = pressed;
            tell("holdpress");
            timer = setInterval(() => held.isConnected ? tell("holdalive") : release(), 100);
        };
        const release = () => {
            if (!held) return;
            clearInterval(timer);
            tell("holdrelease");
            held = null;
        };
        addEventListener("pointerdown", event => {
            if (control(event) && event.button === 0) press(control(event));
        }, true);
        addEventListener("keydown", event => {
            if (!control(event) || ![" ", "Enter"].includes(event.key)) return;
            event.preventDefault();
            if (!event.repeat) press(control(event));
        }, true);
        for (const name of ["pointerup", "pointercancel", "keyup", "pagehide", "visibilitychange"])
            addEventListener(name, release, true);
        addEventListener("blur", event => { if (event.target === window) release(); });
        addEventListener("focusout", event => { if (event.target === held) release(); }, true);
        addEventListener("contextmenu", event => { if (control(event)) event.preventDefault(); });
    })();
</script>"""
"""Sends `holdpress`, `holdalive` ten times a second, and `holdrelease` to an element with the attribute data-hold."""


def draw(page: Page, options: Callable[[], Mapping[str, str]]) -> None:
    """Draw the controls; `options` returns those of a recording."""
    with set_test_id(ui.expansion("Commission one joint", icon="build"), "commission").classes("w-full"):
        with ui.row().classes("items-end gap-3"):
            joint = ui.number("joint", value=1, step=1).classes("w-20")
            by = ui.number("by [rad, or m]", value=0.05, step=0.01).classes("w-28")
            keep_fields(page, "jog", joint=joint, by=by)

            def chosen() -> dict[str, str]:
                return {**{k: v for k, v in options().items() if k in _OPTIONS}, "--joint": as_word(joint) or ""}

            _draw_hold_button(page, lambda: {**chosen(), "--by": as_word(by) or ""})
            for name, label in (("home", "Home"), ("axis-check", "Axis check")):
                page.button(label, name, _ask, page, name, chosen, props="outline")
        state = set_test_id(ui.label(_HINT), "jog-state")

    def update(page: Page) -> None:
        state.text = _state(page.session.recorder.run)

    page.watch(update, "run")


def _draw_hold_button(page: Page, options: Callable[[], Mapping[str, str]]) -> None:
    recorder = page.session.recorder
    is_holding = False

    def press() -> None:
        nonlocal is_holding
        recorder.commission("jog", options())
        is_holding = True

    def keep_alive() -> None:
        # Another browser tab that is held in vain must not keep this one's motion alive.
        if is_holding:
            recorder.keep_alive()

    def release() -> None:
        nonlocal is_holding
        if is_holding:
            recorder.release()
        is_holding = False

    button = set_test_id(ui.button("Hold to move", icon="pan_tool").props("data-hold"), "jog-hold")
    button.style("touch-action: none; user-select: none")
    for event, action in (("holdpress", press), ("holdalive", keep_alive), ("holdrelease", release)):
        button.on(event, page.handler(action), args=[])


def _ask(page: Page, name: str, options: Callable[[], Mapping[str, str]]) -> None:
    chosen = options()
    rig, joint = page.session.recorder.rig_and_joint(chosen)
    question = _QUESTIONS[name].format(joint, rig.position_units[joint - 1])
    page.ask(question, "Move", "Do not move", page.handler(page.session.recorder.commission, name, chosen))


def _state(run: RunStatus | None) -> str:
    """Position, following error, and why the motion ended."""
    if run is None or run.file is not None:
        return _HINT
    position, error = (run.latest(kind) for kind in ("position", "following_error"))
    if position is None or error is None:
        return run_summary(run)
    unit = run.position_unit
    return f"{run_summary(run)} · at {position:+.4f} {unit}, following error {1e3 * error:+.2f} m{unit}"
