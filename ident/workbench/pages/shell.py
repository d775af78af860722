"""Frame of the page: header with the current job, list of recordings, steps and other tabs."""

from collections.abc import Callable, Sequence
from typing import Any

from nicegui import events, ui

from ident.workbench.pages import (
    commission,
    data,
    export,
    fleet,
    missing_effects,
    model,
    record,
    recordings,
    residuals,
    robot,
    style,
    swarm,
    use,
)
from ident.workbench.pages.page import Page, notify, set_test_id
from ident.workbench.state.session import WorkbenchSession
from ident.workbench.topics import Topic

Tab = tuple[str, str, str, Callable[[Page], None], tuple[Topic, ...]]
TABS: tuple[Tab, ...] = (
    ("data", "Choose", "show_chart", data.draw, ("recording",)),
    ("model", "Fit", "stacked_line_chart", model.draw, ("series", "recording")),
    ("residuals", "Where", "troubleshoot", residuals.draw, ("residuals",)),
    ("missing", "Add", "extension", missing_effects.draw, ()),
    ("export", "Save", "save_alt", export.draw, ("residuals", "saved")),
    ("use", "Use it", "rocket_launch", use.draw, ("residuals",)),
    ("record", "Record", "fiber_manual_record", record.draw, ()),
    ("swarm", "Swarm", "bubble_chart", swarm.draw, ()),
    ("robot", "Robot", "precision_manufacturing", robot.draw, ("series", "recording")),
)
"""Key, label, icon, the function that draws the tab, and the topics whose changes redraw all of it, if any. The
steps from the first file to the report come first."""
FLEET: Tab = ("fleet", "Fleet", "groups", fleet.draw, ("fleet",))
"""The tab of a fleet, where a store is open."""


def build(session: WorkbenchSession) -> None:
    """Build the page for one browser tab."""
    ui.colors(primary="#0b5c8c", secondary="#4a5560", info="#4a5560", positive="#00704f", negative="#b3261e")
    ui.add_css(style.CSS)
    ui.add_body_html(style.REPAIRS)
    page, display = Page(session, ui.element("div")), session.display
    opened = session.recordings.train is None and session.fleet is None
    drawer = ui.left_drawer(value=opened, bordered=True)
    props = 'show-if-above width=252 breakpoint=800 aria-label="recordings"'
    with drawer.props(props).classes("q-pa-sm gap-2"):
        recordings.draw(page)
    _header(page, ui.dark_mode(display.dark), drawer)
    ui.add_body_html(commission.HOLD_SCRIPT)
    shown = (*TABS, FLEET) if session.fleet else TABS
    tabs = _tabs(page, shown)
    export.draw_verdict(page)
    content = ui.column().classes("w-full gap-2 q-py-sm")
    drawing = {key: (draw, topics) for key, _, _, draw, topics in shown}

    def show_content() -> None:
        content.clear()  # what is not shown is not there, and nothing is drawn for it
        draw, topics = drawing[str(tabs.value)]
        with content:
            page.draw_on_change(draw, *topics)

    tabs.on_value_change(show_content)
    show_content()
    page.watch(_show_message, "message", now=False)
    client = ui.context.client

    def poll() -> None:
        if client.has_socket_connection:  # nothing is drawn for a browser that is away
            session.recorder.mark_seen()
            page.poll()

    ui.timer(0.2, poll)


def _tabs(page: Page, shown: Sequence[Tab]) -> ui.tabs:
    """Draw the tabs; those of the steps show what is done and what comes next."""
    display = page.session.display

    def show(change: events.ValueChangeEventArguments[Any]) -> None:
        display.tab = str(change.value)
        display.visited.add(display.tab)
        ui.run_javascript(f"noteTab('{display.tab}')")
        page.session.changes.mark("tab")

    tabs = ui.tabs(on_change=show)
    with tabs.props("dense inline-label align=left outside-arrows mobile-arrows no-caps").classes("w-full"):
        elements = {key: set_test_id(ui.tab(key, label, icon), f"tab-{key}") for key, label, icon, *_ in shown}
    tabs.set_value(display.tab)
    page.show_tab = tabs.set_value
    ui.on("went_back", lambda event: tabs.set_value(event.args))

    def mark_steps(page: Page) -> None:
        done = _steps_done(page.session)
        upcoming = done.index(False) if False in done else None
        for index, (is_done, (key, label, *_)) in enumerate(zip(done, TABS, strict=False)):
            tab, title = elements[key], f"{index + 1} {label}"
            tab.props["label"] = title
            tab.props["icon"] = "check_circle" if is_done else "radio_button_unchecked"
            tab.props["aria-label"] = f"{title}{', done' if is_done else ''}"
            tab.classes("step" + (" last-step" if index + 1 == len(done) else ""))
            tab.classes(**{"add" if index == upcoming else "remove": "next-step"})

    page.watch(mark_steps, "folder", "steps", "residuals", "saved", "tab")
    return tabs


def _steps_done(session: WorkbenchSession) -> list[bool]:
    """Return whether each step, in the order of its tab, is done."""
    selection = session.selection
    made, residuals = selection.steps, selection.analysis.residuals
    added = made is not None and bool(made.added)
    seen = residuals is not None and "residuals" in session.display.visited
    return [
        session.recordings.train is not None,
        made is not None,
        selection.within_noise or added or seen,
        selection.within_noise,
        residuals is not None and session.saved.name_of(residuals.model) is not None,
    ]


def _header(page: Page, dark: ui.dark_mode, drawer: ui.left_drawer) -> None:
    session, jobs, recorder = page.session, page.session.jobs, page.session.recorder
    outline = "outline dense color=white"
    with ui.header().classes("items-center q-py-xs q-px-sm gap-2 no-wrap").style("height: 56px"):
        menu = ui.button(icon="menu", on_click=drawer.toggle).props('flat dense color=white aria-label="Recordings"')
        set_test_id(menu, "menu")
        with ui.element("h1"):
            ui.label("delta-workbench")
        status = set_test_id(ui.label().classes("ellipsis").props('role=status aria-live="polite"'), "job")
        spinner = ui.spinner(color="white", size="1.3em")
        cancel = page.button("Cancel", "cancel", jobs.cancel, props=outline)
        ui.space()
        fit = page.button(
            "Fit", "fit", _fit, page, icon="play_arrow", props="dense no-wrap color=white text-color=primary"
        )
        fit.tooltip("Fit the base model with the mandatory effects")
        stop = page.button(
            "STOP", "stop", recorder.stop, icon="dangerous", props="color=negative size=lg push"
        ).tooltip("Ramp down and disable the drives; press again for a quick stop. Key: Esc")

        def toggle_dark() -> None:
            session.display.dark = not session.display.dark
            dark.set_value(session.display.dark)
            session.changes.mark("recording", "steps", "series", "previews", "residuals", "diagnosis", "run")

        props, label = "flat round dense color=white", "Dark or light"
        page.button("", "contrast", toggle_dark, icon="contrast", props=props, label=label).tooltip(label)

    def update() -> None:
        job = jobs.current
        status.text = _status_text(session)
        spinner.visible = cancel.visible = job is not None
        fit.enabled = session.recordings.train is not None and not jobs.blocked
        stop.visible = recorder.running

    def stop_on_escape(pressed: events.KeyEventArguments) -> None:
        if pressed.key.escape and pressed.action.keydown and not pressed.action.repeat and recorder.running:
            recorder.stop()

    ui.keyboard(stop_on_escape, ignore=[])  # also while the user types
    update()
    page.after_action = update
    ui.timer(0.3, update)


def _fit(page: Page) -> None:
    """Fit the base model; ask first if that discards effects that were added."""

    def fit() -> None:
        page.session.selection.fit()
        page.session.display.visited.clear()
        if page.session.display.tab == "data":
            page.show_tab("model")

    page.discard("Another fit of the base model discards the models so far", fit)


def _status_text(session: WorkbenchSession) -> str:
    job, train, validate = session.jobs.current, session.recordings.train, session.recordings.validate
    if job:
        return f"{job.text} … {job.progress}"
    if train is None:
        return "choose a recording"
    made = session.selection.steps
    parts = (f"train {train}", validate and f"validate {validate}", made and made.simulated and "simulated")
    return " · ".join(part for part in parts if part)


def _show_message(page: Page) -> None:
    if page.session.jobs.message:
        notify(page.session.jobs.message, "info")
