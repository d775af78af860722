"""Frame of the page: header with the current job, list of recordings, and tabs."""

from collections.abc import Callable

from nicegui import events, ui

from ident.workbench.folder import SUFFIX
from ident.workbench.pages import data, export, missing_effects, model, record, residuals, robot, swarm
from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.session import WorkbenchSession
from ident.workbench.topics import Job
from web.security import MAX_BODY_BYTES

TABS = (
    ("data", "Recording", "show_chart", data.draw),
    ("model", "Model", "stacked_line_chart", model.draw),
    ("residuals", "Residuals", "troubleshoot", residuals.draw),
    ("missing", "Missing effects", "extension", missing_effects.draw),
    ("swarm", "Swarm", "bubble_chart", swarm.draw),
    ("robot", "Robot", "precision_manufacturing", robot.draw),
    ("record", "Record", "fiber_manual_record", record.draw),
    ("export", "Export", "save_alt", export.draw),
)
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
    page = Page(session)
    ui.colors(
        primary="#0b5c8c",
        secondary="#4a5560",
        info="#4a5560",
        positive="#00805c",
        negative="#b3261e",
    )
    ui.add_css(_STYLE)
    dark = ui.dark_mode(session.dark)
    _header(page, dark)
    with ui.left_drawer(value=True, bordered=True).props("width=252 behavior=desktop").classes("q-pa-sm gap-2"):
        _recordings(page)
    with ui.tabs().props("dense inline-label align=left no-caps").classes("w-full") as tabs:
        for key, label, icon, _ in TABS:
            set_test_id(ui.tab(key, label, icon), f"tab-{key}")
    tabs.set_value(session.tab)
    tabs.on_value_change(lambda change: setattr(session, "tab", change.value))
    page.show_tab = lambda tab: _turn_to(tabs, tab)
    with ui.tab_panels(tabs, value=session.tab, animated=False, keep_alive=False).classes("w-full"):
        for key, _, _, draw in TABS:
            with ui.tab_panel(key):
                draw(page)
    page.call_on_change(lambda: _notify(session), "message")
    ui.timer(0.2, page.poll)


def _turn_to(tabs: ui.tabs, tab: str) -> None:
    tabs.set_value(tab)


def _header(page: Page, dark: ui.dark_mode) -> None:
    session = page.session
    with ui.header().classes("items-center q-py-xs gap-3 no-wrap").style("height: 64px"):
        ui.label("delta-workbench").classes("text-lg font-medium")
        job = ui.label().classes("ellipsis").props('role=status aria-live="polite"')
        set_test_id(job, "job")
        spinner = ui.spinner(color="white", size="1.3em")
        cancel = ui.button("Cancel", on_click=page.handler(session.cancel)).props("outline dense color=white")
        set_test_id(cancel, "cancel")
        pause = ui.button("Pause", on_click=page.handler(session.pause)).props("outline dense color=white")
        resume = ui.button("Resume", on_click=page.handler(session.resume)).props("outline dense color=white")
        set_test_id(pause, "pause")
        set_test_id(resume, "resume")
        ui.space()
        stop = ui.button("STOP", icon="dangerous", on_click=page.handler(session.recorder.stop))
        stop.props("color=negative size=lg push").tooltip(
            "Ramp down and disable the drives; press again for a quick stop. Key: Esc"
        )
        set_test_id(stop, "stop")

        def toggle_dark() -> None:
            session.dark = not session.dark
            dark.set_value(session.dark)
            session.mark_changed(
                "recording", "ladder", "series", "previews", "residuals", "diagnosis", "swarm_progress", "run"
            )

        contrast = ui.button(icon="contrast", on_click=toggle_dark).tooltip("Dark or light")
        contrast.props('flat round color=white aria-label="Dark or light"')
        set_test_id(contrast, "contrast")

    def update() -> None:
        busy = session.job is not None
        paused = session.job is not None and session.job.paused_at is not None
        job.text = _job_text(session.job) if session.job else _status_text(session)
        spinner.visible = pause.visible = busy and not paused
        resume.visible, cancel.visible = paused, busy
        stop.visible = session.recorder.running

    def stop_on_escape(pressed: events.KeyEventArguments) -> None:
        if pressed.key.escape and pressed.action.keydown and not pressed.action.repeat and session.recorder.running:
            session.recorder.stop()

    ui.keyboard(stop_on_escape, ignore=[])  # also while the user types
    update()
    page.after_action = update
    ui.timer(0.3, update)


def _job_text(job: Job) -> str:
    return f"{job.text}: paused after {job.seconds:.0f} s" if job.paused_at else f"{job.text} … {job.seconds:.0f} s"


def _status_text(session: WorkbenchSession) -> str:
    if session.train is None:
        return "choose a recording on the left"
    simulated = " · simulated" if session.ladder and session.ladder.simulated else ""
    return f"train {session.train}" + (f" · check {session.validate}" if session.validate else "") + simulated


def _notify(session: WorkbenchSession) -> None:
    if session.message:
        ui.notify(session.message, type="info", position="bottom", timeout=8000, close_button=True)


def _recordings(page: Page) -> None:
    session = page.session
    ui.label("Recordings").classes("head")
    root = session.folder.root
    ui.label(f"in {root.name or root}").classes("quiet ellipsis w-full").tooltip(str(root))
    page.draw_on_change(lambda: _draw_list(page), "folder")
    ui.label(
        "Train: fit the model to this recording. Check: validate it on this recording of another motion."
    ).classes("quiet")

    async def add(upload: events.UploadEventArguments) -> None:
        await _save_upload(page, upload)
        box.run_method("removeUploadedFiles")  # they are now in the list above

    box = ui.upload(on_upload=add, auto_upload=True, multiple=True, max_file_size=MAX_BODY_BYTES)
    box.props(f'label="Drop files here" accept={SUFFIX} flat bordered').classes("w-full q-mt-sm")
    box.on(
        "rejected",
        lambda: ui.notify("Only .mcap files of up to 256 MiB are accepted; copy larger ones into the folder."),
    )
    set_test_id(box, "upload")


async def _save_upload(page: Page, upload: events.UploadEventArguments) -> None:
    from recordings.errors import BadInput

    session = page.session
    try:
        path = session.folder.new_file(upload.file.name, SUFFIX)
        await upload.file.save(path)
    except BadInput as error:
        ui.notify(str(error), type="warning", position="bottom", timeout=8000, close_button=True)
    session.mark_changed("folder")


def _draw_list(page: Page) -> None:
    session = page.session
    names = session.folder.recordings()
    if not names:
        ui.label("No recordings here yet: record one, or drop a file below.").classes("quiet")
    for number, file_name in enumerate(names):
        with ui.row().classes("w-full items-center no-wrap gap-1 q-mb-xs"):
            ui.label(file_name).classes("ellipsis col").tooltip(file_name)
            for text, selected, action in (
                ("Train", file_name == session.train, _train_handler(session, file_name)),
                ("Check", file_name == session.validate, _check_handler(session, file_name)),
            ):
                button = ui.button(text, on_click=page.handler(action)).props("dense size=sm no-caps")
                button.props("unelevated" if selected else "outline")
                button.props(f"aria-pressed={'true' if selected else 'false'}")
                set_test_id(button, f"{text.lower()}-{number}")


def _train_handler(session: WorkbenchSession, file_name: str) -> Callable[[], None]:
    return lambda: session.choose(file_name, None if session.validate == file_name else session.validate)


def _check_handler(session: WorkbenchSession, file_name: str) -> Callable[[], None]:
    return lambda: session.choose(session.train, None if session.validate == file_name else file_name)
