"""The service, as Python calls."""

from __future__ import annotations

import hashlib
import json
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

from .errors import ContuseError, InvalidScene, JobFailed, ServiceProblem, Unreachable
from .recording import Recording
from .wire import Job, Mesh, Problem, Progress, Summary

#: A document as JSON has it, or the path of one.
Document = Mapping[str, Any] | str | Path
#: Tries of a request or a stream that breaks off, and the first rest between them [s]; each is twice the one before.
TRIES = 5
REST_S = 0.2


class Client:
    """A service at an address, with its bearer token if it wants one."""

    def __init__(self, address: str, token: str | None = None, timeout_s: float = 60.0) -> None:
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._http = httpx.Client(base_url=address, headers=headers, timeout=timeout_s)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        self._http.close()

    def validate(self, scene: Document) -> dict[str, Any]:
        """What a scene would be: bodies, plan, expected run time. Meshes beside it are uploaded. Raises `InvalidScene` with every mistake."""
        answer: dict[str, Any] = self._post("/v1/jobs/validate", self._bytes_of(scene)).json()
        return answer

    def upload(self, path: str | Path) -> Mesh:
        """Uploads a mesh file. Scenes name it by its id, `{"file": {"name": mesh.id}}`; the same file has the same id."""
        answer = self._post("/v1/meshes", Path(path).read_bytes(), {"Content-Type": "application/octet-stream"})
        return Mesh.of(answer.json())

    def first_scene(self, mesh: Mesh | str, radius_m: float | None = None) -> dict[str, Any]:
        """A scene of an uploaded mesh, scan or closed surface to begin with: `scene`, `parts`, `sets`, and where a ball of that radius touches it (`touches`)."""
        mesh_id = mesh.id if isinstance(mesh, Mesh) else mesh
        parameters = {} if radius_m is None else {"radius_m": str(radius_m)}
        begun: dict[str, Any] = self._get(f"/v1/meshes/{mesh_id}/first-scene", params=parameters).json()
        return begun

    def submit(self, scene: Document, priority: str = "normal") -> Job:
        """Submits a scene (a document, or the path of one, whose mesh files are uploaded). Sent again after a broken connection, it is still one job.
        Of your waiting jobs those with the `priority` `high` begin first, those with `low` last."""
        return self._submitted("/v1/jobs", scene, priority)

    def what_if(self, question: Document, priority: str = "normal") -> Job:
        """Asks what would be if. The base is `job`, the id of a job, or `scene`, a document or its path; `results` has the answer."""
        return self._submitted("/v1/what-if", question, priority)

    def study(self, study: Document, priority: str = "normal") -> Job:
        """Submits a study, of `kind` `error` (its `scene` is a document or its path) or `stability`; `results` has what it says."""
        return self._submitted("/v1/studies", study, priority)

    def job(self, job: Job | str) -> Job:
        """The job as it stands."""
        return Job.of(self._get(f"/v1/jobs/{_id(job)}").json())

    def jobs(self, state: str | None = None) -> Iterator[Job]:
        """All jobs, newest first."""
        parameters = {"state": state} if state else {}
        while True:
            page = self._get("/v1/jobs", params=parameters).json()
            yield from map(Job.of, page["jobs"])
            if not page["next_cursor"]:
                return
            parameters["cursor"] = page["next_cursor"]

    def wait(self, job: Job | str, on_progress: Callable[[Progress], None] | None = None) -> Job:
        """Follows a job to its end. Raises `JobFailed` unless it succeeds."""
        for event, data in self._events(_id(job)):
            if event == "progress" and on_progress:
                on_progress(Progress(data["phase"], data["progress"], data["step"], data["simulated_time_s"], data["eta_s"]))
        ended = self.job(job)
        if ended.state != "succeeded":
            raise JobFailed(ended)
        return ended

    def cancel(self, job: Job | str) -> Job:
        """Stops a job; its recording so far is kept."""
        return Job.of(self._post(f"/v1/jobs/{_id(job)}/cancel", b"{}").json())

    def delete(self, job: Job | str) -> None:
        """Removes a job and its recording."""
        try:
            _checked(self._http.delete(f"/v1/jobs/{_id(job)}"))
        except httpx.TransportError as error:
            # A second try could find that the first one did it, and call that a problem.
            raise self._unreachable(error) from error

    def summary(self, job: Job | str) -> Summary:
        """The clinical summary of a job that has ended."""
        return Summary(self.results(job))

    def results(self, job: Job | str) -> dict[str, Any]:
        """The summary of a job that has ended as it is on the wire: the answer to a what-if question, the rows or cells of a study."""
        results: dict[str, Any] = self._get(f"/v1/jobs/{_id(job)}/summary").json()
        return results

    def recording(self, job: Job | str, path: str | Path) -> Recording:
        """Downloads the recording of a job that has ended, goes on where it broke off, checks the digest, and opens it."""
        expected = self.job(job).body["recording"]
        if expected is None:
            raise ContuseError(f"job {_id(job)} has no final recording")
        path = Path(path)
        partial = path.with_name(path.name + ".partial")
        for attempt in range(TRIES):
            try:
                self._download(f"/v1/jobs/{_id(job)}/recording", partial, expected)
                break
            except httpx.TransportError as error:
                if attempt + 1 == TRIES:
                    raise self._unreachable(error) from error
                _rest(attempt)
        digest = hashlib.sha256(partial.read_bytes()).hexdigest()
        if digest != expected["sha256"]:
            partial.unlink()
            raise ContuseError(f"the download of job {_id(job)} is damaged: SHA-256 {digest}, not {expected['sha256']}")
        partial.replace(path)
        return Recording(path)

    def surface(self, job: Job | str, path: str | Path, time_s: float | None = None) -> Path:
        """Writes the deformed surfaces of a job to `path`, by its suffix `.stl` or `.ply`: at the field time nearest to `time_s`, or the last one."""
        path = Path(path)
        if path.suffix not in (".stl", ".ply"):
            raise ContuseError(f"{path}: surfaces are written as .stl or .ply")
        parameters = {} if time_s is None else {"time_s": str(time_s)}
        path.write_bytes(self._get(f"/v1/jobs/{_id(job)}/export{path.suffix}", params=parameters).content)
        return path

    def _download(self, address: str, partial: Path, expected: dict[str, Any]) -> None:
        """Appends what is missing; only bytes of the expected file come."""
        held = partial.stat().st_size if partial.exists() else 0
        if held >= expected["bytes"]:
            return
        headers = {"Range": f"bytes={held}-", "If-Range": f'"{expected["sha256"]}"'}
        with self._http.stream("GET", address, headers=headers) as answer:
            if answer.is_error:
                answer.read()
            _checked(answer)
            with open(partial, "ab" if answer.status_code == 206 else "wb") as file:
                for piece in answer.iter_bytes():
                    file.write(piece)

    def _events(self, job: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """Events of a job to its end; a stream that breaks off goes on after the last that was heard."""
        last, attempt = "0", 0
        while True:
            try:
                headers = {"Last-Event-ID": last, "Accept": "text/event-stream"}
                # Heartbeats come every few seconds; silence beyond the timeout is a broken connection.
                with self._http.stream("GET", f"/v1/jobs/{job}/events", headers=headers) as answer:
                    if answer.is_error:
                        answer.read()
                    _checked(answer)
                    if answer.status_code == 204:
                        return
                    for last, event, data in _parsed(answer.iter_lines()):
                        attempt = 0
                        yield event, data
                        if event in ("succeeded", "failed", "cancelled"):
                            return
            except httpx.TransportError as error:
                if attempt + 1 >= TRIES:
                    raise self._unreachable(error) from error
            _rest(attempt)
            attempt += 1

    def _submitted(self, address: str, document: Document, priority: str) -> Job:
        headers = {"Idempotency-Key": str(uuid.uuid4()), "Job-Priority": priority}
        return Job.of(self._post(address, self._bytes_of(document), headers).json())

    def _bytes_of(self, document: Document) -> bytes:
        """The bytes of a document. Files go as they are, unless they name mesh files beside them: these are uploaded, and named by their ids."""
        if not isinstance(document, (str, Path)):
            scene = document.get("scene")
            inner = {"scene": json.loads(self._bytes_of(scene))} if isinstance(scene, (str, Path)) else {}
            return json.dumps({**document, **inner}).encode()
        content, folder = Path(document).read_bytes(), Path(document).resolve().parent
        try:
            read = json.loads(content)
        except ValueError:
            # The service says where it breaks off.
            return content
        files = [file for file in _mesh_files(read) if _is_beside(folder, file["name"])]
        if not files:
            return content
        ids = {name: self.upload(folder / name).id for name in sorted({file["name"] for file in files})}
        for file in files:
            file["name"] = ids[file["name"]]
        return json.dumps(read).encode()

    def _get(self, path: str, params: dict[str, str] | None = None) -> httpx.Response:
        return self._tried(lambda: self._http.get(path, params=params))

    def _post(self, path: str, body: bytes, headers: dict[str, str] | None = None) -> httpx.Response:
        headers = {"Content-Type": "application/json", **(headers or {})}
        return self._tried(lambda: self._http.post(path, content=body, headers=headers))

    def _tried(self, send: Callable[[], httpx.Response]) -> httpx.Response:
        """Sends again when the connection breaks: every request of this client may be repeated."""
        attempt = 0
        while True:
            try:
                return _checked(send())
            except httpx.TransportError as error:
                if attempt + 1 == TRIES:
                    raise self._unreachable(error) from error
            _rest(attempt)
            attempt += 1

    def _unreachable(self, error: Exception) -> Unreachable:
        return Unreachable(str(self._http.base_url), error)


def _rest(attempt: int) -> None:
    time.sleep(REST_S * 2**attempt)


def _id(job: Job | str) -> str:
    return job.id if isinstance(job, Job) else job


def _mesh_files(value: Any) -> Iterator[dict[str, Any]]:
    """What names a mesh, a scan or a surface, wherever it stands in a document: the insides of `{"file": {"name": …}}` and the like."""
    if isinstance(value, dict):
        surfaces = value.get("surfaces")
        named = [value.get("file"), value.get("segmentation"), value.get("shape"), *(surfaces if isinstance(surfaces, list) else [])]
        yield from (file for file in named if isinstance(file, dict) and isinstance(file.get("name"), str))
        value = list(value.values())
    if isinstance(value, list):
        for inner in value:
            yield from _mesh_files(inner)


def _is_beside(folder: Path, name: str) -> bool:
    """Whether a name is that of a file in the folder: a scene of others must not name what lies elsewhere."""
    path = (folder / name).resolve()
    return path.is_relative_to(folder) and path.is_file()


def _checked(answer: httpx.Response) -> httpx.Response:
    if not answer.is_error:
        return answer
    is_json = "json" in answer.headers.get("content-type", "")
    body: dict[str, Any] = answer.json() if is_json else {"detail": answer.text}
    if body.get("errors"):
        raise InvalidScene(answer.status_code, body, [Problem.of(error) for error in body["errors"]])
    raise ServiceProblem(answer.status_code, body)


def _parsed(lines: Iterator[str]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Id, name and data of server-sent events."""
    fields: dict[str, str] = {}
    for line in lines:
        if not line:
            if "data" in fields:
                yield fields.get("id", "0"), fields.get("event", "message"), json.loads(fields["data"])
            fields = {}
        elif not line.startswith(":"):
            name, _, value = line.partition(":")
            fields[name] = value.removeprefix(" ")
