"""Answering queries between two steps of the loop, never from the bus' own threads."""

from __future__ import annotations

import queue
from collections.abc import Callable
from typing import TYPE_CHECKING

from shared.parameters import Refused
from shared.requests import ParameterRequest, ParameterTable
from shared.schema.fields import InvalidField
from shared.schema.records import Record
from shared.topics import LONGEST_REASON, Query
from shared.wire.bus import OnRequest, Reply
from shared.wire.codec import Rejected, decode_map, encode_map

if TYPE_CHECKING:
    from shared.service import Service

_WAITING_QUERIES = 32
_MALFORMED = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
"""Errors that a request can cause which nobody expected. Requests come from anybody and must not end the service."""


class QueryDesk:
    """Queues requests as they arrive and answers them when the loop says so.

    Args:
        service: asked for everything but its parameters.
        wake: called when a request has arrived.
    """

    def __init__(self, service: Service, wake: Callable[[], None]) -> None:
        self._service = service
        self._wake = wake
        self._waiting: queue.Queue[tuple[Query, bytes, Reply]] = queue.Queue(_WAITING_QUERIES)

    def inbox(self, query: Query) -> OnRequest:
        """The callback that takes requests of one key; it refuses one itself only while too many are waiting."""
        too_many = _refused(f"{query.key}: {_WAITING_QUERIES} requests are waiting already; ask again later")

        def on_request(payload: bytes, reply: Reply) -> None:
            try:
                self._waiting.put_nowait((query, payload, reply))
            except queue.Full:
                reply(too_many)
                return
            self._wake()

        return on_request

    def serve(self) -> tuple[str, bytes] | None:
        """Answer one request, so that however many there are they delay a step by no more than that.

        Returns:
            Its key and payload; None if nothing was asked.
        """
        if self._waiting.empty():
            return None
        query, payload, reply = self._waiting.get_nowait()

        def answer(found: Record | Refused) -> None:
            reply(_refused(str(found)) if isinstance(found, Refused) else _granted(found))

        try:
            request = query.request(decode_map(payload) if payload else {})
            if query == self._service.wiring.parameters:
                answer(self._set_parameters(request))
            else:
                self._service.query(query, request, answer)
        except (Refused, Rejected, InvalidField) as problem:
            reply(_refused(str(problem)))
        except _MALFORMED as problem:
            reply(_refused(f"{query.key} cannot make sense of the request ({type(problem).__name__}: {problem})"))
        if not self._waiting.empty():
            self._wake()
        return query.key, payload

    def _set_parameters(self, request: Record) -> ParameterTable:
        assert isinstance(request, ParameterRequest)
        if request.set is not None:
            self._service.apply(self._service.parameters.changed(request.set))
        return ParameterTable(self._service.parameters.table())


def _granted(answer: Record) -> bytes:
    return encode_map({"ok": True, **answer.to_plain()})


def _refused(reason: str) -> bytes:
    return encode_map({"ok": False, "error": reason[:LONGEST_REASON]})
