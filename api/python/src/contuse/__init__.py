"""Client of a Contuse service: submit impacts, wait, read summaries and recordings.

Research use only: not a medical device, not a diagnosis.
"""

from .client import Client
from .errors import ContuseError, InvalidScene, JobFailed, NotMeasured, RecordingError, ServiceProblem, Unreachable, Withheld
from .recording import Frame, Recording
from .wire import InjuryMeasure, Job, Mesh, Problem, Progress, Quantity, Summary

__all__ = [
    "Client",
    "ContuseError",
    "Frame",
    "InjuryMeasure",
    "InvalidScene",
    "Job",
    "JobFailed",
    "Mesh",
    "NotMeasured",
    "Problem",
    "Progress",
    "Quantity",
    "Recording",
    "RecordingError",
    "ServiceProblem",
    "Summary",
    "Unreachable",
    "Withheld",
]
