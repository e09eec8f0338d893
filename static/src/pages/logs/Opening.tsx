/** Shown in place of a log's view until it has loaded. */
export function Opening() {
  return (
    <div class="viewer-message" role="status">
      <p class="prose">Opening the log …</p>
      <div class="progress waiting wide">
        <span />
      </div>
    </div>
  );
}
