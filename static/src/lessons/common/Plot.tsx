import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import "./lesson.css";
import { useWidth } from "../../ui/useWidth";

interface PlotProps {
  readonly height: number;
  /** What it shows, where it is a picture; without it what stands in it speaks for itself. */
  readonly label?: string;
  /** Drawn in the pixels of the page, so that text stays as large on a phone as elsewhere. */
  readonly children: (width: number) => ComponentChildren;
}

/** A chart as wide as its place. */
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
