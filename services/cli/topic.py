"""`tandem topic list|echo|hz`: what is said on the bus."""

from __future__ import annotations

import queue
import time
from typing import Annotated, Any

import typer
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from services.cli.common import (
    DEFAULT_ENDPOINT,
    DEFAULT_ROBOT,
    AsJson,
    Connect,
    Robot,
    example,
    open_bus,
    refuse,
    waiting,
)
from services.cli.health.watch import Watch
from services.cli.listing import Listing, show_json
from shared import topics
from shared.clock import SteadyClock
from shared.schema.valid_json import valid_json
from shared.topics import topic_by_key
from shared.wire.client import unheard
from shared.wire.subscription import Received, Subscription

app = typer.Typer(help="What is said on the bus.")


def keys() -> list[str]:
    """Every key of the contract, for completion."""
    return [topic.key for topic in topics.TOPICS]


Key = Annotated[str, typer.Argument(help="Key without the robot, such as wrench/external.", autocompletion=keys)]


@app.command("list", epilog=example("tandem topic list"))
def list_topics() -> None:
    """Every topic of the contract: key, who publishes it, nominal rate, fields with units."""
    shown = Listing("key", "publisher", "rate [Hz]", "fields")
    for topic in (*topics.TOPICS, *topics.own_topics("<service>")):
        fields = ", ".join(f"{name} [{kind.unit}]" if kind.unit else name for name, kind, _ in topic.message.kinds())
        rate = f"{topic.rate:g}" if topic.rate else "on change"
        shown.add(topic.key, topic.publisher, rate, fields)
    Console().print(shown)


@app.command(epilog=example("tandem topic echo wrench/external --count 3"))
def echo(
    key: Key,
    count: Annotated[int, typer.Option(min=0, help="End after this many messages; 0 = go on until Ctrl-C.")] = 0,
    within: Annotated[float, typer.Option(help="Give up when nothing is heard for this long [s].")] = 5.0,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Print the messages of one topic, a JSON object per line."""
    topic = topic_by_key(key)
    if topic is None:
        refuse(f"{key!r} is no topic of the contract; see: tandem topic list")
    heard: queue.SimpleQueue[Received] = queue.SimpleQueue()
    subscription: Subscription = Subscription(topic, SteadyClock(), heard.put)
    printed = 0
    with open_bus(robot, connect) as bus:
        bus.subscribe(topic.key, subscription.offer)
        try:
            while not count or printed < count:
                with waiting(f"nothing of {key} yet; after {within:g} s this ends and says why", within):
                    received = heard.get(timeout=within)
                header = {"seq": received.header.seq, "valid": received.header.valid}
                typer.echo(valid_json(header | _readable(received.message.to_plain())))
                printed += 1
        except queue.Empty:
            refuse(f"{robot}/{key}: nothing to show for {within:g} s: {unheard(subscription)}", 1)
        except KeyboardInterrupt:
            return


@app.command(epilog=example("tandem topic hz sensor/ft --seconds 5"))
def hz(
    key: Annotated[str, typer.Argument(help="One key; all of them if left out.", autocompletion=keys)] = "",
    seconds: Annotated[float, typer.Option(min=0.5, help="How long to listen [s].")] = 2.0,
    watch: Annotated[bool, typer.Option("--watch", help="Go on until Ctrl-C.")] = False,
    as_json: AsJson = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Measured rate, age and rejected messages of every topic that is heard."""
    if key and topic_by_key(key) is None:
        refuse(f"{key!r} is no topic of the contract; see: tandem topic list")
    if watch and as_json:
        refuse("--watch and --json: choose one; --json is one document, after --seconds")
    with open_bus(robot, connect) as bus:
        listening = Watch(bus, also=key)
        if watch:
            try:
                with Live(refresh_per_second=4) as live:
                    while True:
                        time.sleep(0.25)
                        live.update(_shown(_rates(listening, key)) or Text("nothing heard yet; see: tandem status"))
            except KeyboardInterrupt:
                return
        with waiting(f"listens for {seconds:g} s; less with --seconds, all the time with --watch", seconds):
            time.sleep(seconds)
        rates = _rates(listening, key)
        if as_json:
            show_json({"robot": robot, "endpoint": connect, "listened_s": seconds, "topics": rates})
        elif rates:
            Console().print(_shown(rates))
        if not rates:
            refuse(f"nothing heard on {robot}/{key or '**'} for {seconds:g} s: is a stack running there?", 1)


def _rates(watch: Watch, only: str) -> list[dict[str, Any]]:
    """What is measured of each topic that is heard, and what is wrong with what was refused of it."""
    found = []
    now, trouble = SteadyClock().now_ns(), watch.trouble()
    for key, subscription in watch.subscriptions.items():
        if (only and key != only) or (subscription.latest is None and not subscription.rejected):
            continue
        topic = subscription.topic
        one = {
            "key": key,
            "measured_hz": round(subscription.rate(now), 1),
            "nominal_hz": topic.rate or None,
            "age_ms": round(1e3 * subscription.age(now)) if subscription.latest else None,
            "rejected": subscription.rejected + subscription.out_of_order + subscription.second_session,
            "publisher": topic.publisher,
            "wrong": trouble.get(key, ""),
        }
        found.append(one)
    return found


def _shown(rates: list[dict[str, Any]]) -> Group | None:
    """A row per topic, and below them what is wrong; None if nothing is heard."""
    shown = Listing("key", "measured [Hz]>", "nominal [Hz]>", "age [ms]>", "rejected>", "publisher")
    for one in rates:
        nominal = "on change" if one["nominal_hz"] is None else f"{one['nominal_hz']:g}"
        age = "never" if one["age_ms"] is None else str(one["age_ms"])
        shown.add(one["key"], f"{one['measured_hz']:.1f}", nominal, age, str(one["rejected"]), one["publisher"])
    return Group(shown, *(Text(one["wrong"], style="red") for one in rates if one["wrong"])) if rates else None


def _readable(value: Any) -> Any:
    """Floats to six significant digits; images by their size."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, bytes):
        return f"{len(value)} bytes"
    if isinstance(value, list):
        return [_readable(element) for element in value]
    if isinstance(value, dict):
        return {name: _readable(element) for name, element in value.items()}
    return value
