"""The window of the render mode "human"."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle._optional import require

__all__ = ["Window"]


class Window:
    """A window that shows pictures at a given rate.

    Parameters
    ----------
    title : str
        Title of the window.

    Raises
    ------
    gymnasium.error.DependencyNotInstalled
        If pygame is not installed.
    """

    def __init__(self, title: str = "trundle") -> None:
        self._pygame: Any = _pygame()
        self._title = title
        self._clock = self._pygame.time.Clock()
        self._opened = self._closed = False

    @property
    def closed(self) -> bool:
        """Whether the window was closed, by the user or by `close()`. It cannot be reopened."""
        return self._closed

    def show(self, pixels: NDArray[np.uint8], fps: float) -> None:
        """Show a picture and wait according to `fps`; does nothing once the window is closed."""
        if self._closed:
            return
        surface = self._surface((pixels.shape[1], pixels.shape[0]))
        picture = self._pygame.image.frombuffer(pixels.tobytes(), surface.get_size(), "RGB")
        surface.blit(picture, (0, 0))
        self._pygame.display.flip()
        if any(event.type == self._pygame.QUIT for event in self._pygame.event.get()):
            self.close()
            return
        self._clock.tick(fps)

    def close(self) -> None:
        """Close the window; repeated calls have no effect."""
        if self._opened and not self._closed:
            self._pygame.display.quit()
        self._closed = True

    def _surface(self, size: tuple[int, int]) -> Any:
        """Return the surface of the window; open it if needed, such as after another window was closed."""
        display = self._pygame.display
        surface = display.get_surface() if display.get_init() else None
        if surface is None or surface.get_size() != size:
            display.init()
            surface = display.set_mode(size)
            display.set_caption(self._title)
            self._opened = True
        return surface


def _pygame() -> Any:
    try:
        return require("pygame", "human", "windows of render_mode='human'")
    except TrundleError as error:
        raise DependencyNotInstalled(f"{error}, or use render_mode='rgb_array'") from error
