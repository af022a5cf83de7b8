"""Where a proof about episodes tells the starts of two apart that may touch.

Does: chooses the cuts of a gap of starts: to what its zone allows, to where the two are apart for sure, into cells.
Assumes: a cut of the checker's reading (checker/episodes/contacts.py) keeps all starts, so any choice is sound.
Does not: bound pushes.
"""

from collections.abc import Iterator

from verify.checker.episodes.contacts import CUT, ContactReading
from verify.checker.episodes.reading import GRID, Box, Gap, Now

CELL = GRID >> 5  # gaps of starts that may touch are told apart so far: each piece has a narrower push
MAX_CELLS = 1 << 10  # of one gap; beyond it, it stays whole
GAIN = GRID >> 14  # a bound that is nearer by less is not worth its bytes


def where(episode: ContactReading, gap: Gap, allowed: Box, now: Now, finely: bool) -> int:
    """Where to cut a gap, as a number of the proof; 0 for nowhere. `allowed`: what its zone lets it be; `finely`: also
    where some starts lie on either side.
    """
    if episode.apart(gap, now):
        return 0
    tighter = list(_tighter(gap, allowed))
    enough = [(axis, at) for axis, at, trimmed in tighter if episode.apart(trimmed, now)]
    cuts = enough or [(axis, at) for axis, at, _ in tighter]
    if not cuts and finely:
        cuts = list(_lines(episode, gap, now))
    if not cuts and finely and not episode.strange(gap):  # who does anything may soon be anywhere: cells say little
        cuts = list(_middle(gap))
    return _number(*cuts[0]) if cuts else 0


def _number(axis: int, at: int) -> int:
    """Returns the number that `ContactReading.cut` reads."""
    place = at // CUT
    return 1 + axis + 2 * (2 * place if place >= 0 else -2 * place - 1)


def _tighter(gap: Gap, allowed: Box) -> Iterator[tuple[int, int, Gap]]:
    """(axis, place, what is left) of the cuts that leave nothing out, where they are worth it."""
    for axis in (0, 1):
        (low, high), (least, most) = gap.starts[axis], allowed[axis]
        if low + GAIN < least < high:
            yield axis, least, gap.within(axis, (least, high))
        if low < most < high - GAIN:
            yield axis, most, gap.within(axis, (low, most))


def _lines(episode: ContactReading, gap: Gap, now: Now) -> Iterator[tuple[int, int]]:
    """(axis, place) of cuts beyond which the two are apart on that axis alone."""
    reach = episode.contacts[gap.pair].reach
    added = episode.gap(Gap(gap.pair, ((0, 0), (0, 0))), now)  # by movements
    for axis, (low, high) in enumerate(added):
        for at in (-((low - reach) // CUT) * CUT, (-reach - high) // CUT * CUT):
            if gap.starts[axis][0] < at < gap.starts[axis][1]:
                yield axis, at


def _middle(gap: Gap) -> Iterator[tuple[int, int]]:
    """(axis, place) of the cut in halves of what is larger than a cell."""
    widths = [high - low for low, high in gap.starts]
    axis = widths.index(max(widths))
    if widths[axis] > CELL and (widths[0] // CELL + 1) * (widths[1] // CELL + 1) <= MAX_CELLS:
        yield axis, sum(gap.starts[axis]) // 2 // CUT * CUT
