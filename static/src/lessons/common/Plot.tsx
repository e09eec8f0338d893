import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import "./lesson.css";
import { useDrawing } from "../../ui/browser/useDrawing";

interface PlotProps {
  readonly height: number;
  /** Description for screen readers; without it the elements inside have their own. */
  readonly label?: string;
  /** Draws in pixels, so that text has the same size on a phone as elsewhere. */
  readonly children: (width: number) => ComponentChildren;
}

/** A chart that is as wide as its container. */
export function Plot({ height, label, children }: PlotProps) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale } = useDrawing(box, 720).value;
  return (
    <div
      class="plot"
      ref={box}
      style={{ height: `${scale * height}px` }}
      {...(label ? { role: "img", "aria-label": label } : {})}
    >
      <svg
        class="drawing"
        style={{ zoom: scale }}
        width={width}
        height={height}
        viewBox={`0 0 ${width} ${height}`}
        role="presentation"
      >
        {children(width)}
      </svg>
    </div>
  );
}
