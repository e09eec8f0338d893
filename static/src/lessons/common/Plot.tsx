import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import "./lesson.css";
import { useWidth } from "../../ui/browser/useWidth";

interface PlotProps {
  readonly height: number;
  /** Description for screen readers; without it the elements inside have their own. */
  readonly label?: string;
  /** Draws in CSS pixels, so that text has the same size on a phone as elsewhere. */
  readonly children: (width: number) => ComponentChildren;
}

/** A chart that is as wide as its container. */
export function Plot({ height, label, children }: PlotProps) {
  const box = useRef<HTMLDivElement>(null);
  const width = useWidth(box, 720);
  return (
    <div
      class="plot"
      ref={box}
      style={{ height: `${height}px` }}
      {...(label ? { role: "img", "aria-label": label } : {})}
    >
      <svg width={width.value} height={height} viewBox={`0 0 ${width.value} ${height}`} role="presentation">
        {children(width.value)}
      </svg>
    </div>
  );
}
