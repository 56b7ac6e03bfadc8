"""The life of what is made of components, from instantiating to freeing: every call of it is watched."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any, Protocol, TypeVar

from orchestration.instances.instance import CallFailed, Instance
from orchestration.process.watch import Hung, Watched
from orchestration.process.where import Where

_GIVEN_UP: list[Any] = []


class Living(Protocol):
    """A context manager with instances of components."""

    @property
    def instances(self) -> Mapping[str, Instance]:
        """The components by name."""
        ...

    @property
    def warnings(self) -> list[str]:
        """What is to be told of them."""
        ...

    def __exit__(self, *error: Any) -> None: ...


Made = TypeVar("Made", bound=Living)


@contextmanager
def watched_life(
    make: Callable[[], Made], where: Where, timeout: float, account: dict[str, Any]
) -> Iterator[tuple[Made, Watched]]:
    """Make something, yield it with the thread that it lives in, and end it there.

    A call that does not return within `timeout` (s) becomes CallFailed, except at the end: all rows are there then, and
    it becomes one of the `warnings` in `account`, to which those of what was made are added. What hangs may come back:
    nothing that it works on is freed.
    """
    before = list(account.get("warnings", ()))

    def tell() -> None:
        account["warnings"] = [*before, *made.warnings]

    watched = Watched(lambda: where.pulse, timeout=timeout)
    try:
        try:
            made = watched(make, throw=True)
        except Hung as hung:
            raise _interrupted_or(hung_failure(hung, timeout), watched) from None
        if watched.interrupted:
            watched(partial(made.__exit__, KeyboardInterrupt, None, None))
            raise KeyboardInterrupt
        try:
            yield made, watched
        except BaseException as error:
            tell()
            if watched.lost:
                for instance in made.instances.values():
                    instance.abandon()
                _GIVEN_UP.append(made)
                where.idle()
                made.__exit__(type(error), error, None)
            else:
                with suppress(Hung):
                    watched(partial(made.__exit__, type(error), error, None))
            if isinstance(error, Hung):
                raise _interrupted_or(hung_failure(error, timeout), watched) from None
            raise
        tell()
        where.finish()
        try:
            watched(partial(made.__exit__, None, None, None))
        except Hung as hung:
            _GIVEN_UP.append(made)
            where.idle()
            account["warnings"].append(f"{hung_failure(hung, timeout)}; all rows are there")
        except Exception as error:  # whatever it is, the run is over
            account["warnings"].append(f"at the end of the run: {' '.join(str(error).split())}")
        else:
            tell()
    finally:
        watched.close()


def hung_failure(hung: Hung, timeout: float) -> CallFailed:
    """Put into words that a call did not return."""
    _, component, action, *_ = hung.doing
    return CallFailed(component or "the system", f"{action} did not return within {timeout:g} s")


def _interrupted_or(failure: CallFailed, watched: Watched) -> BaseException:
    return KeyboardInterrupt() if watched.interrupted else failure
