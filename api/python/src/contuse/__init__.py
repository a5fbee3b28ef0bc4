"""Client of a Contuse service: submit impacts, wait, read summaries and recordings.

Research use only: not a medical device, not a diagnosis.
"""

from .client import Client
from .errors import ContuseError, InvalidScene, JobFailed, ServiceProblem, Withheld
from .recording import Frame, Recording
from .wire import Job, Problem, Progress, Quantity, Summary

__all__ = [
    "Client",
    "ContuseError",
    "Frame",
    "InvalidScene",
    "Job",
    "JobFailed",
    "Problem",
    "Progress",
    "Quantity",
    "Recording",
    "ServiceProblem",
    "Summary",
    "Withheld",
]
