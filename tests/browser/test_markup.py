"""What others write is text: markup from the aircraft and from people, 500 times, and nothing of it runs or can be clicked."""

from __future__ import annotations

import itertools
import unicodedata

import pytest
from playwright.async_api import expect
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.browser.conftest import OpenStation, Serve
from tests.faults.mock import MockPlane

RUN = "window.ran=1"
SHAPES = (
    "<script>{run}</script>",
    "<img src=x onerror={run}>",
    "<svg onload={run}>",
    "<svg><script>{run}</script></svg>",
    "<iframe src='javascript:parent.{run}'></iframe>",
    "<a href='javascript:{run}' id=x>here</a>",
    "<a href='http://192.0.2.1/'>update</a>",
    "<details open ontoggle={run}>",
    "<body onload={run}>",
    "<input autofocus onfocus={run}>",
    "<style>*{{display:none}}</style>",
    "<meta http-equiv=refresh content='0;url=http://192.0.2.1'>",
    "<base href='http://192.0.2.1/'>",
    "<object data='javascript:{run}'></object>",
    "<math><mtext></mtext><script>{run}</script></math>",
    "&lt;script&gt;{run}&lt;/script&gt;",
    "&#60;img src=x onerror={run}&#62;",
    "{{{{constructor.constructor('{run}')()}}}}",
    "{{@html '<img src=x onerror={run}>'}}",
    "javascript:{run}",
)
AROUND = (
    "{}", '">{}', "'>{}", "</li>{}", "</span></ol>{}", "</textarea>{}", "</title>{}", "-->{}<!--", "]]>{}", "`{}`",
    "{{{}}}", "${{{}}}", "\\x3c{}", "%3C{}", "\N{RIGHT-TO-LEFT OVERRIDE}{}", "\N{FULLWIDTH LESS-THAN SIGN}{}",
    "http://192.0.2.1/{}", "mailto:{}", "//{}", "\n{}", "\t{}", "{}\0", "PreArm: {}", "Mode {} changed", "<{}>",
)  # fmt: skip
PAYLOADS = [around.format(shape.format(run=RUN)) for shape, around in itertools.product(SHAPES, AROUND)]
CHUNK = 50
BATCH = 125
"""Of which the page and the server have room for all."""
FOREIGN = """(ours) => [...document.querySelectorAll('script, iframe, object, embed, base, meta[http-equiv], a, details, math, *')]
    .filter((element) => element.tagName === 'SCRIPT' ? !element.src.startsWith(location.origin)
        : element.tagName === 'A' ? !ours.includes(element.getAttribute('href'))
        : ['IFRAME', 'OBJECT', 'EMBED', 'BASE', 'MATH'].includes(element.tagName)
            || element.tagName === 'META' && element.httpEquiv === 'refresh'
            || [...element.attributes].some((attribute) => attribute.name.startsWith('on')))
    .map((element) => element.outerHTML.slice(0, 120))"""


def chunks(text: str, number: int) -> list[mavlink.MAVLink_statustext_message]:
    """A text as a vehicle sends it: in pieces of fifty bytes, the last one shorter, by which its end is known."""
    data = text.encode("utf-8", "replace")
    pieces = [data[at : at + CHUNK] for at in range(0, len(data) + 1, CHUNK)]
    return [mavlink.MAVLink_statustext_message(6, piece, number, place) for place, piece in enumerate(pieces)]


def bare(text: str) -> str:
    """A text without white space and control characters: those that differ in these alone are one row of the list."""
    return "".join(character for character in text if unicodedata.category(character)[0] not in "CZ")


@pytest.mark.fault(
    46,
    figure="500 payloads in texts of several chunks, one as a person's name: shown as text, 0 scripts, links, frames, handlers",
)
async def test_markup_of_others_is_text(open_station: OpenStation, serve: Serve) -> None:
    assert len(PAYLOADS) == len(set(PAYLOADS)) == 500
    with MockPlane() as mock:
        served = serve("--link", mock.link)
        other = served.client(name=PAYLOADS[1])
        async with open_station(served.url) as station:
            asked: list[str] = []
            station.page.on("dialog", lambda dialog: asked.append(dialog.message))
            station.page.on("popup", lambda popup: asked.append(popup.url))
            await expect(station.bar("bar.mode")).to_contain_text("MANUAL")
            # What the page has of its own.
            ours = await station.page.evaluate("[...document.querySelectorAll('a')].map((a) => a.getAttribute('href'))")
            assert await station.page.evaluate(FOREIGN, ours) == []
            panel = await station.open_panel("messages")
            drawn: set[str] = set()
            for start in range(0, len(PAYLOADS), BATCH):
                batch = PAYLOADS[start : start + BATCH]
                said = [piece for number, text in enumerate(batch) for piece in chunks(text, start + number + 1)]
                last = f"that was {start}"
                mock.do(lambda said=said, last=last: mock.say(*said, *chunks(last, 60_000)))  # type: ignore[misc]
                await expect(panel.get_by_text(last, exact=True)).to_be_visible()
                drawn |= {bare(text) for text in await panel.locator("li .text").all_inner_texts()}
                assert await station.page.evaluate(FOREIGN, ours) == []
            assert {bare(text) for text in PAYLOADS} <= drawn, "they were shown, as the text that they are"
            # A person who is called like that wants control.
            await station.have_control()
            assert other.ask("POST", "control/request").status == 200
            await expect(station.page.get_by_role("status").get_by_text(RUN)).to_be_visible()
            assert await station.page.evaluate(FOREIGN, ours) == []
            assert await station.page.evaluate("window.ran") is None
            assert asked == []
            assert station.page.url.startswith(served.url)
