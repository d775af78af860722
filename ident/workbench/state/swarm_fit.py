"""Fit of the parameters by particle swarm, as the page shows it."""

from functools import partial

from ident.workbench.state.chosen_recordings import ChosenRecordings
from ident.workbench.state.cli_equivalent import effect_options, left_out, swarm_command
from ident.workbench.topics import Changes
from ident.workbench.worker.jobs import Jobs
from ident.workbench.worker.views import StepsView, SwarmProgress, SwarmRequest, SwarmResult, View


class SwarmFit:
    """Progress and result."""

    def __init__(self, recordings: ChosenRecordings, jobs: Jobs, changes: Changes) -> None:
        self._recordings, self._jobs, self._changes = recordings, jobs, changes
        self.progress: SwarmProgress | None = None
        """Convergence of the running swarm, or of the last one."""
        self.result: SwarmResult | None = None
        self.command = ""
        """Terminal command that is equivalent to that of the result."""
        jobs.on_end.append(self._show_result)

    def clear(self) -> None:
        """Discard everything."""
        self.result = None
        self._changes.mark("swarm_result")
        self._show_result()

    def start(self, seed: int, step_list: StepsView | None) -> None:
        """Fit the current model of `step_list`, or the base model."""
        request = SwarmRequest(seed=seed)
        if step_list:
            request = SwarmRequest(effect_options(step_list), step_list.bandwidth, seed, left_out(step_list))
        train, validate = self._recordings.files
        command = swarm_command(request, train.name, validate.name if validate else None)
        self._jobs.submit("swarm", partial(self._receive, command), "swarm", train, validate, request)

    def _receive(self, command: str, view: View) -> None:
        match view:
            case SwarmProgress():
                self.progress = view
                self._changes.mark("swarm_progress")
            case SwarmResult():
                self.result, self.command = view, command
                self._changes.mark("swarm_result")

    def _show_result(self, completed: bool = True) -> None:
        """Show the last result when a job has ended, whether or not it was `completed`."""
        self.progress = self.result.progress if self.result else None
        self._changes.mark("swarm_progress")
