import { computed } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import { Button } from "../../ui/Button";
import { isBoolean, isWithin, kept } from "../../ui/browser/kept";
import { useMedia } from "../../ui/browser/media";
import { Icon } from "../../ui/Icon";
import { Splitter } from "../../ui/split/Splitter";
import "./viewer.css";

const LIMITS = { low: 0.25, high: 0.82 };
const BESIDE = 2 / 3;
const BELOW = 0.62;

/** The share of the window for the map and its time slider, with the dock beside or below them. */
const beside = kept("gridbloom.logs.column", BESIDE, isWithin(LIMITS.low, LIMITS.high));
const below = kept("gridbloom.logs.column-below", BELOW, isWithin(LIMITS.low, LIMITS.high));
const isHidden = kept("gridbloom.logs.column-hidden", false, isBoolean);

/** Show the hidden dock, because something in it was requested. */
export function showColumn(): void {
  isHidden.value = false;
}

interface ViewerFrameProps {
  readonly class?: string;
  /** The head and the stage. */
  readonly children: ComponentChildren;
  readonly dock: ComponentChildren;
}

/**
 * The page of one log: head and stage, and beside or below them the dock, whose border can be dragged and which can be
 * hidden.
 */
export function ViewerFrame({ class: className = "", children, dock }: ViewerFrameProps) {
  const id = useId();
  const isNarrow = useMedia("(max-width: 61.99rem)").value;
  const share = isNarrow ? below : beside;
  const dockSize = computed(() => `${(1 - share.value) * 100}%`);
  const hidden = isHidden.value;
  return (
    <div
      class={`viewer ${hidden ? "is-wide" : ""} ${className}`}
      style={{ "--dock-size": hidden ? "0px" : dockSize.value }}
      data-split=""
    >
      {children}
      <div class="viewer-border">
        <Button
          kind="quiet"
          icon={hidden ? (isNarrow ? "up" : "back") : isNarrow ? "unfold" : "forward"}
          label={hidden ? "Show the column" : "Hide the column"}
          onClick={() => {
            isHidden.value = !hidden;
          }}
        />
        {!hidden && (
          <Splitter
            label="Size of the column"
            controls={id}
            axis={isNarrow ? "y" : "x"}
            share={share.value}
            limits={LIMITS}
            onShare={(next) => {
              share.value = next;
            }}
            onReset={() => {
              share.value = isNarrow ? BELOW : BESIDE;
            }}
          />
        )}
      </div>
      <div class="viewer-dock" id={id}>
        {dock}
      </div>
    </div>
  );
}

interface ViewerStatusProps {
  readonly hello: object | null;
  readonly trouble: string | null;
  /** Shown until the session has answered. */
  readonly opening: string;
}

/** Over the map: the error of the connection, or that the session is being opened. */
export function ViewerStatus({ hello, trouble, opening }: ViewerStatusProps) {
  if (hello && !trouble) return null;
  return (
    <p class="viewer-over" role="status">
      {trouble ? <Icon name="warning" /> : null} {trouble ?? opening}
    </p>
  );
}
