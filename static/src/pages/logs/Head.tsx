import { useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";

interface HeadProps {
  readonly store: Store;
  /** Back to the logs; not for a guest, whose session is a copy. */
  readonly onClose: (() => void) | undefined;
  /** At the right end: additions come before the rest, which stays in place. */
  readonly children?: ComponentChildren;
}

/** The title of the log, above its map. */
export function Head({ store, onClose, children }: HeadProps) {
  const hello = store.hello.value;
  return (
    <header class="viewer-head">
      {onClose && <Button kind="quiet" icon="back" label="All logs" onClick={onClose} />}
      <h1 title={hello?.title}>{hello?.title ?? "…"}</h1>
      <RecomputeTime store={store} />
      {children}
      {!onClose && <span class="guest-note">Shared view: your changes are not seen by others.</span>}
    </header>
  );
}

/** Time that the server took to compute the whole map again. */
function RecomputeTime({ store }: { readonly store: Store }) {
  const last = useSignal<{ ms: number; scans: number } | null>(null);
  useSignalEffect(() => {
    const frame = store.frame.value;
    if (frame?.remade_ms !== undefined) last.value = { ms: frame.remade_ms, scans: frame.index };
  });
  if (!last.value) return null;
  const { ms, scans } = last.value;
  return (
    <output class="viewer-badge" data-remade={ms}>
      {scans} scans re-mapped in {ms < 10 ? written(ms, 1) : Math.round(ms)} ms
    </output>
  );
}
