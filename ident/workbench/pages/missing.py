"""The mission: fit, see the ladder, look what could be added, add it, watch the error fall."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages import branching, candidates, findings
from ident.workbench.pages.page import Page, name, picture
from ident.workbench.views import LadderView, RungView


def draw(page: Page) -> None:
    """Everything about effects."""
    _buttons(page)
    page.follow(lambda: _ladder(page), "ladder")
    page.follow(lambda: branching.draw(page), "ladder")
    page.follow(lambda: findings.draw(page), "answer")
    candidates.draw(page)


def _buttons(page: Page) -> None:
    session = page.session
    with ui.row().classes("items-center gap-2"):
        fit = ui.button("Fit", icon="play_arrow", on_click=page.does(session.fit))
        fit.tooltip("Fit the base model, and what is true of any such machine")
        undo = ui.button("Undo", icon="undo", on_click=page.does(session.undo)).props("outline")
        redo = ui.button("Redo", icon="redo", on_click=page.does(session.redo)).props("outline")
        fork = ui.button("New branch", icon="call_split", on_click=page.does(session.fork)).props("outline")
        fork.tooltip("Keep this ladder, and go on in a copy of it, to see two explanations side by side")
        full = ui.button("Full diagnosis", icon="biotech", on_click=page.does(session.diagnose)).props("outline")
        full.tooltip("Let the program climb by itself, and question every finding: half a minute")
        for element, what in ((fit, "fit"), (undo, "undo"), (redo, "redo"), (fork, "fork"), (full, "diagnose")):
            name(element, what)
            element.props("no-caps")

    def allow() -> None:
        free = session.job is None or not session.job.urgent
        fit.enabled = free and session.train is not None
        present = session.branches.present if session.branches else None
        undo.enabled = free and present is not None and len(present.past) > 1
        redo.enabled = free and present is not None and bool(present.future)
        fork.enabled = full.enabled = free and present is not None

    allow()
    page.watch(allow, "job", "folder", "ladder")


def _ladder(page: Page) -> None:
    session, ladder = page.session, page.session.ladder
    if ladder is None:
        ui.label(
            "Fit the base model to the recording: how much of the torque it explains is shown here, rung by rung, as "
            "effects are added. Choose a second recording with Check, to see whether it holds on another motion."
        ).classes("quiet")
        return
    picture(plots.ladder(ladder), "error of each model, training and held out", session.dark)
    _table(ladder)
    notes = [f"Held out: {ladder.held_out}. Noise floor: what a right model would leave, noise and encoder steps."]
    notes += ["Torques are relative: the gain is assumed."] if ladder.relative else []
    notes += [f"Of these long recordings {100 * ladder.excerpt:.0f} % was looked at."] if ladder.excerpt else []
    ui.label(" ".join(notes)).classes("quiet")
    _present(page, ladder.rungs[-1])


def _table(ladder: LadderView) -> None:
    joints = range(len(ladder.joints))
    unit = ladder.units[0]
    with ui.element("table").classes("figures ladder"):
        with ui.element("tr"):
            titles = [f"training j{j + 1} [{unit}]" for j in joints] + [f"held out j{j + 1} [{unit}]" for j in joints]
            for title in ("model", *titles, "gain on held out"):
                with ui.element("th"):
                    ui.label(title)
        for number, rung in enumerate(ladder.rungs):
            with ui.element("tr"):
                with ui.element("td"):
                    name(ui.label(f"{number}  {rung.label}"), f"rung-{number}")
                for kind, values in (("train", rung.entry.train_rms), ("held", rung.entry.validate_rms)):
                    for j in joints:
                        with ui.element("td"):
                            name(ui.label(f"{values[j]:.4f}"), f"{kind}-{number}-{j + 1}")
                with ui.element("td"):
                    ui.label(_gain(rung))


def _gain(rung: RungView) -> str:
    if rung.gain is None or rung.gain_ci95 is None:
        return ""
    gain, low, high = (round(100 * share) for share in (rung.gain, *rung.gain_ci95))
    return f"{gain} % ({low} to {high})"


def _present(page: Page, rung: RungView) -> None:
    if not rung.terms:
        return
    with ui.row().classes("items-center gap-2 q-mt-xs"):
        ui.label("In the model:")
        for index, (effect, joints) in enumerate(rung.terms):
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                ui.label(f"{effect}{_where(joints, rung)}")
                remove = ui.button("Remove", on_click=page.does(page.session.remove, index))
                remove.props(f'flat dense size=sm no-caps aria-label="Remove {effect}"')
                name(remove, f"remove-{effect}")


def _where(joints: tuple[int, ...], rung: RungView) -> str:
    whole = len(joints) == len(rung.entry.train_rms)
    return "" if whole else f" (joint {', '.join(map(str, joints))})"
