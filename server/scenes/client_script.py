"""Script inserted before those of viser's client page."""

#: It reports each message that was worked off (:mod:`server.scenes.pacing`): viser's worker sends what is posted to it
#: as ``send`` once it has told of the connection, and a message is worked off in the frame after its arrival. The
#: first report says that the page has this script.
#:
#: Viser's client connects again only while its document has the focus, which a view inside of a page rarely has. Here
#: it is enough that the page is visible.
SCRIPT = b"""<script>
window.Worker = class extends window.Worker {
  constructor(...given) {
    super(...given);
    const report = () => this.postMessage({ type: "send", message: { type: "GridbloomDrawn" } });
    this.addEventListener("message", ({ data }) => {
      if (data?.type === "connected") report();
      if (data?.type === "message_batch") requestAnimationFrame(() => requestAnimationFrame(report));
    });
  }
};
document.hasFocus = () => document.visibilityState === "visible";
document.addEventListener("visibilitychange", () => window.dispatchEvent(new Event("focus")));
</script>"""
