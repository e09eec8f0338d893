import "./slidePicture.css";
import { useEffect, useRef } from "preact/hooks";
import { useWidth } from "../../../../ui/browser/useSize";
import { SLIDE } from "../scale";

/** A slide as the audience sees it, without its controls, laid out at full size and scaled down. */
export function SlidePicture({ hash, title }: { readonly hash: string; readonly title: string }) {
  const box = useRef<HTMLDivElement>(null);
  const frame = useRef<HTMLIFrameElement>(null);
  const first = useRef(hash);
  const width = useWidth(box, SLIDE.width / 4);
  useEffect(() => {
    const inside = frame.current?.contentWindow;
    if (inside && inside.location.pathname === location.pathname && inside.location.hash !== hash)
      inside.location.replace(`${location.pathname}?present=view${hash}`);
  }, [hash]);
  return (
    <div class="slide-picture" ref={box}>
      <iframe
        ref={frame}
        title={title}
        tabIndex={-1}
        src={`/lecture.html?present=view${first.current}`}
        style={`width: ${SLIDE.width}px; height: ${SLIDE.height}px; scale: ${width.value / SLIDE.width}`}
        inert
      />
    </div>
  );
}
