"""A fit on the screen: parameters, agreement per joint, and where the model fails."""

from rich.console import Console
from rich.table import Table

from ident.identification import Identification
from ident.model import Agreement, JointFitness, Model


def show(result: Identification, console: Console) -> None:
    """Print everything a person needs to judge `result`."""
    model = result.model
    for line in notices(result):
        console.print(line, style="bold yellow", highlight=False)
    console.print(_parameters(model))
    console.print(_agreements(model))
    judged = "validation" if result.validation else "training"
    console.print(f"Where the model fails ({judged} data, {model.preprocessing.bandwidth:g} Hz bandwidth):")
    for sentence in result.where():
        console.print(f"  {sentence}", highlight=False)


def notices(result: Identification) -> list[str]:
    """What must be known before a figure is believed."""
    model = result.model
    agreements = [model.train, *([model.validate_] if model.validate_ else [])]
    simulated = [source.name for agreement in agreements for source in agreement.recordings if source.simulated]
    datasets = [*result.train, *([result.validation] if result.validation else [])]
    incomplete = [dataset.recording.path.name for dataset in datasets if not dataset.recording.complete]
    at_bound = [parameter.name for parameter in model.parameters if parameter.at_bound]
    lines = []
    if simulated:
        lines.append(f"SIMULATED data: {', '.join(simulated)}.")
    if incomplete:
        lines.append(f"Interrupted, used as far as it goes: {', '.join(incomplete)}.")
    if model.relative:
        lines.append(
            "The torque gain is assumed, not calibrated: the parameters are RELATIVE, known up to one common factor."
        )
    if model.geometry.L2_source == "assumed":
        lines.append(f"The forearm length L2 = {model.geometry.L2:g} m is assumed; 10 mm shift m_p by about 10 %.")
    if at_bound:
        lines.append(f"On the edge of the search region, so not determined by the data: {', '.join(at_bound)}.")
    return lines


def _parameters(model: Model) -> Table:
    label = ", relative" if model.relative else ""
    table = Table(title=f"Parameters of Eq. (26){label}", title_justify="left")
    for heading, justify in (("", "left"), ("value", "right"), ("unit", "left"), ("as in (36)", "right")):
        table.add_column(heading, justify=justify)  # type: ignore[arg-type]
    table.add_column("at bound")
    for parameter in model.parameters:
        table.add_row(
            parameter.name,
            f"{parameter.value:.4f}",
            parameter.unit,
            f"{parameter.paper_value:.4f}",
            "yes" if parameter.at_bound else "",
        )
    table.caption = "Friction is positive where it opposes motion; (36) has the opposite sign."
    return table


def _agreements(model: Model) -> Table:
    table = Table(title="Agreement with the measured torque: fitted model | Table 1 in Eq. (1)", title_justify="left")
    table.add_column("data")
    table.add_column("joint")
    for measure in ("Eq. (41)", "RMS [N m]", "R²"):
        table.add_column(measure, justify="right")
    judged: list[tuple[str, Agreement | None]] = [("training", model.train), ("validation", model.validate_)]
    for name, agreement in judged:
        if agreement:
            for joint in range(len(model.joints)):
                fitted, nominal = _cells(agreement.fitted, joint), _cells(agreement.nominal, joint)
                both = [f"{one} | {other}" for one, other in zip(fitted, nominal, strict=True)]
                table.add_row(name if joint == 0 else "", str(joint + 1), *both)
            table.add_section()
    return table


def _cells(fitness: JointFitness, joint: int) -> list[str]:
    return [f"{fitness.nrmse[joint]:.4f}", f"{fitness.rms[joint]:.3f}", f"{fitness.r2[joint]:.4f}"]
