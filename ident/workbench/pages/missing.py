"""The mission: fit, see the ladder, look what could be added, add it, watch the error fall."""

from collections.abc import Callable

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages import findings
from ident.workbench.pages.page import Page, name, picture
from ident.workbench.views import Candidate, LadderView, RungView

_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(290px, 1fr))"


def draw(page: Page) -> None:
    """Everything about effects."""
    _buttons(page)
    page.follow(lambda: _ladder(page), "ladder")
    page.follow(lambda: findings.draw(page), "answer")
    page.follow(lambda: _cards(page), "choice", "ladder")


def _buttons(page: Page) -> None:
    session = page.session
    with ui.row().classes("items-center gap-2"):
        fit = ui.button("Fit", icon="play_arrow", on_click=page.does(session.fit))
        fit.tooltip("Fit the base model, and what is true of any such machine")
        undo = ui.button("Undo", icon="undo", on_click=page.does(session.undo)).props("outline")
        full = ui.button("Full diagnosis", icon="biotech", on_click=page.does(session.diagnose)).props("outline")
        full.tooltip("Let the program climb by itself, and question every finding: half a minute")
        for element, what in ((fit, "fit"), (undo, "undo"), (full, "diagnose")):
            name(element, what)
            element.props("no-caps")

    def allow() -> None:
        free = session.job is None or not session.job.urgent
        fit.enabled = free and session.train is not None
        undo.enabled = free and session.ladder is not None and session.ladder.can_undo
        full.enabled = free and session.ladder is not None

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
    notes = [f"Held out: {ladder.held_out}. Noise floor: what a right model would leave."]
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
    return f"{100 * rung.gain:.0f} % ({100 * rung.gain_ci95[0]:.0f} to {100 * rung.gain_ci95[1]:.0f})"


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


def _cards(page: Page) -> None:
    session, choice = page.session, page.session.choice
    if session.ladder is None:
        return
    if choice is None:
        ui.label("Looking at every effect of the library …").classes("quiet")
        return
    ui.label("What could be missing").classes("head q-mt-sm")
    ui.label("Share of the squared error that each would take away at first sight, the model refitted.").classes(
        "quiet"
    )
    with ui.element("div").classes("w-full grid gap-2").style(_COLUMNS):
        for candidate in choice.candidates:
            _card(page, candidate)
    if choice.unseen:
        ui.label(f"This motion does not show: {', '.join(choice.unseen)}.").classes("quiet q-mt-sm")
    for effect, why in choice.unobservable.items():
        ui.label(f"{effect}: {why}").classes("quiet")


def _card(page: Page, candidate: Candidate) -> None:
    effect = page.session.library[candidate.name]
    joints = f"joint {', '.join(map(str, candidate.joints))}" if candidate.joints else "whole robot"
    card = ui.card().classes("q-pa-sm gap-1").props("flat bordered")
    name(card, f"card-{candidate.name}")
    with card:
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(candidate.name).classes("font-medium ellipsis")
            ui.space()
            name(ui.label(f"{100 * candidate.gain:.1f} %"), f"gain-{candidate.name}")
        ui.linear_progress(candidate.gain, show_value=False, size="6px").props("aria-hidden=true")
        ui.label(effect.sentence).classes("text-sm")
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(joints).classes("quiet")
            ui.space()
            with ui.button("About").props("flat dense size=sm no-caps"), ui.menu().classes("q-pa-md max-w-md"):
                for label, text in _about(page, candidate.name):
                    ui.label(label).classes("quiet")
                    ui.label(text).classes("q-mb-xs")
            add = ui.button("Add", on_click=_adds(page, candidate.name)).props("dense size=sm no-caps unelevated")
            add.props(f'aria-label="Add {candidate.name}"')
            name(add, f"add-{candidate.name}")


def _about(page: Page, effect: str) -> list[tuple[str, str]]:
    known = page.session.library[effect]
    return [
        ("Equation", known.equation),
        ("What it looks like", known.looks),
        ("Usual causes", known.causes),
        ("What to do", known.remedy),
    ]


def _adds(page: Page, effect: str) -> Callable[[], None]:
    return page.does(page.session.add, effect)
