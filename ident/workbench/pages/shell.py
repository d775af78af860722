"""Frame of the page: header with the current job, list of recordings, tabs."""

from collections.abc import Callable

from nicegui import events, ui

from ident.workbench.jobs import Job
from ident.workbench.pages import data, export, missing_effects, model, record, recordings, residuals, robot, swarm
from ident.workbench.pages.page import Page, notify, set_test_id
from ident.workbench.session import WorkbenchSession
from ident.workbench.topics import Topic

TABS: tuple[tuple[str, str, str, Callable[[Page], None], tuple[Topic, ...]], ...] = (
    ("data", "Recording", "show_chart", data.draw, ("recording",)),
    ("model", "Model", "stacked_line_chart", model.draw, ("series",)),
    ("residuals", "Residuals", "troubleshoot", residuals.draw, ("residuals",)),
    ("missing", "Missing effects", "extension", missing_effects.draw, ()),
    ("swarm", "Swarm", "bubble_chart", swarm.draw, ()),
    ("robot", "Robot", "precision_manufacturing", robot.draw, ("series", "recording")),
    ("record", "Record", "fiber_manual_record", record.draw, ()),
    ("export", "Export", "save_alt", export.draw, ("residuals", "ladder")),
)
"""Key, label, icon, the function that draws the tab, and the topics whose changes redraw all of it, if any."""
_STYLE = """
.q-tab__label, .q-btn { text-transform: none !important; letter-spacing: 0; }
.q-tab__label { font-size: 0.95rem; }
.nicegui-content { padding: 0.75rem 1rem; }
.q-tab-panel { padding: 0.5rem 0; }
.head { font-size: 1.05rem; font-weight: 600; margin: 0.25rem 0; }
.quiet { opacity: 0.72; font-size: 0.88rem; }
.figures td, .figures th { padding: 2px 10px; text-align: right; font-variant-numeric: tabular-nums; }
.figures td:first-child, .figures th:first-child { text-align: left; }
.figures th { font-weight: 600; opacity: 0.75; }
.ladder tr:last-child td { font-weight: 600; }
.figures td.words, .figures th.words { text-align: left; }
.body--dark .q-btn--outline, .body--dark .q-btn--flat { --q-primary: #8cc8f2; }
.q-tab { padding: 0 10px; }
.q-tab__icon { font-size: 20px !important; }
.q-tab-panels { background: transparent !important; }
.q-tab-panels, .q-tab-panels .q-panel, .q-tab-panel { overflow: visible; }
.preview { position: sticky; top: 64px; z-index: 5; background: #fff; border-bottom: 1px solid #8886; }
.preview:empty { border: 0; }
.body--dark .preview { background: #121212; }
.chip { border: 1px solid rgba(128, 128, 128, 0.5); border-radius: 6px; padding: 0 8px; }
:focus-visible { outline: 2px solid var(--q-primary); outline-offset: 2px; }
"""


def build(session: WorkbenchSession) -> None:
    """Build the page for one browser tab."""
    page, display = Page(session), session.display
    ui.colors(
        primary="#0b5c8c",
        secondary="#4a5560",
        info="#4a5560",
        positive="#00805c",
        negative="#b3261e",
    )
    ui.add_css(_STYLE)
    _header(page, ui.dark_mode(display.dark))
    with ui.left_drawer(value=True, bordered=True).props("width=252 behavior=desktop").classes("q-pa-sm gap-2"):
        recordings.draw(page)
    tabs = ui.tabs(on_change=lambda change: setattr(display, "tab", change.value))
    with tabs.props("dense inline-label align=left").classes("w-full"):
        for key, label, icon, *_ in TABS:
            set_test_id(ui.tab(key, label, icon), f"tab-{key}")
    tabs.set_value(display.tab)
    page.show_tab = tabs.set_value
    with ui.tab_panels(tabs, value=display.tab, animated=False, keep_alive=False).classes("w-full"):
        for key, _, _, draw, topics in TABS:
            with ui.tab_panel(key):
                if topics:
                    page.draw_on_change(draw, *topics)
                else:
                    draw(page)
    page.call_on_change(_show_message, "message")
    ui.timer(0.2, page.poll)


def _header(page: Page, dark: ui.dark_mode) -> None:
    session, jobs, recorder = page.session, page.session.jobs, page.session.recorder
    outline = "outline dense color=white"
    with ui.header().classes("items-center q-py-xs gap-3 no-wrap").style("height: 64px"):
        ui.label("delta-workbench").classes("text-lg font-medium")
        status = set_test_id(ui.label().classes("ellipsis").props('role=status aria-live="polite"'), "job")
        spinner = ui.spinner(color="white", size="1.3em")
        cancel = page.button("Cancel", "cancel", jobs.cancel, props=outline)
        pause = page.button("Pause", "pause", jobs.pause, props=outline)
        resume = page.button("Resume", "resume", jobs.resume, props=outline)
        ui.space()
        stop = page.button(
            "STOP", "stop", recorder.stop, icon="dangerous", props="color=negative size=lg push"
        ).tooltip("Ramp down and disable the drives; press again for a quick stop. Key: Esc")

        def toggle_dark() -> None:
            session.display.dark = not session.display.dark
            dark.set_value(session.display.dark)
            session.changes.mark(
                "recording", "ladder", "series", "previews", "residuals", "diagnosis", "swarm_progress", "run"
            )

        props = 'flat round color=white aria-label="Dark or light"'
        page.button("", "contrast", toggle_dark, icon="contrast", props=props).tooltip("Dark or light")

    def update() -> None:
        job = jobs.current
        paused = job is not None and job.paused_at is not None
        status.text = _job_text(job) if job else _status_text(session)
        spinner.visible = pause.visible = job is not None and not paused
        resume.visible, cancel.visible = paused, job is not None
        stop.visible = recorder.running

    def stop_on_escape(pressed: events.KeyEventArguments) -> None:
        if pressed.key.escape and pressed.action.keydown and not pressed.action.repeat and recorder.running:
            recorder.stop()

    ui.keyboard(stop_on_escape, ignore=[])  # also while the user types
    update()
    page.after_action = update
    ui.timer(0.3, update)


def _job_text(job: Job) -> str:
    return f"{job.text}: paused after {job.seconds:.0f} s" if job.paused_at else f"{job.text} … {job.seconds:.0f} s"


def _status_text(session: WorkbenchSession) -> str:
    train, validate, ladder = session.recordings.train, session.recordings.validate, session.selection.ladder
    if train is None:
        return "choose a recording on the left"
    parts = (f"train {train}", validate and f"validate {validate}", ladder and ladder.simulated and "simulated")
    return " · ".join(part for part in parts if part)


def _show_message(page: Page) -> None:
    if page.session.jobs.message:
        notify(page.session.jobs.message, "info")
