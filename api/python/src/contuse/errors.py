"""What can go wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .wire import Job, Problem


class ContuseError(Exception):
    """The root of the others."""


class Unreachable(ContuseError):
    """No answer came from the address, however often it was asked."""

    def __init__(self, address: str, cause: Exception) -> None:
        super().__init__(f"no answer from {address}: {cause or type(cause).__name__}. Does the service run there (`contuse serve --listen …`)?")
        self.address = address


class ServiceProblem(ContuseError):
    """An answer of the service that is no success (RFC 9457)."""

    def __init__(self, status: int, body: dict[str, Any]) -> None:
        words = [body.get("detail") or body.get("title") or f"the service answered {status}", body.get("remedy")]
        super().__init__(" ".join(word for word in words if word))
        self.status = status
        self.body = body


class InvalidScene(ServiceProblem):
    """The scene has mistakes: all of them are in `problems`."""

    def __init__(self, status: int, body: dict[str, Any], problems: list[Problem]) -> None:
        super().__init__(status, body)
        self.problems = problems

    def __str__(self) -> str:
        return "\n".join([super().__str__(), *(f"  {problem}" for problem in self.problems)])


class JobFailed(ContuseError):
    """The job ended without success; its recording so far is kept."""

    def __init__(self, job: Job) -> None:
        failure = job.failure or {}
        super().__init__(f"job {job.id} {job.state}: {failure.get('message', 'without a diagnosis')} {failure.get('remedy', '')}".strip())
        self.job = job


class RecordingError(ContuseError):
    """The file is not a complete recording, or lacks what was requested of it."""


class NotMeasured(ContuseError):
    """The summary has no such number: the scene has nothing to measure it on, or the run did not come that far."""


class Withheld(ContuseError):
    """The run failed a gate: no number of it is a result."""
