"""Pages whose frames and messages are late, as on a busy machine: tests that do not wait for them fail each time.

``GRIDBLOOM_LATE_MS=150 make test PYTEST=tests/browser`` runs the browser tests so.
"""

from __future__ import annotations

import os

LATE_MS = int(os.environ.get("GRIDBLOOM_LATE_MS", "0"))

# Animation frames are asked for later; messages of the stream are sent and received later, in their order.
_SCRIPT = """(() => {
  const frame = window.requestAnimationFrame.bind(window);
  const cancel = window.cancelAnimationFrame.bind(window);
  const waiting = new Map();
  let newest = 0;
  window.requestAnimationFrame = (task) => {
    const id = ++newest;
    const run = (now) => { waiting.delete(id); task(now); };
    const ask = () => {
      const asked = frame(run);
      waiting.set(id, () => cancel(asked));
    };
    const timer = setTimeout(ask, LATE_MS);
    waiting.set(id, () => clearTimeout(timer));
    return id;
  };
  window.cancelAnimationFrame = (id) => { waiting.get(id)?.(); waiting.delete(id); };
  window.WebSocket = class extends window.WebSocket {
    #task = null;
    get onmessage() { return this.#task; }
    set onmessage(task) {
      this.#task = task;
      super.onmessage = task && ((event) => setTimeout(() => this.#task?.call(this, event), LATE_MS));
    }
    send(data) { setTimeout(() => { if (this.readyState === WebSocket.OPEN) super.send(data); }, LATE_MS); }
  };
})()"""


def late_script() -> str | None:
    """Return what a page runs first so that all is late; None where nothing is to be."""
    return _SCRIPT.replace("LATE_MS", str(LATE_MS)) if LATE_MS else None
