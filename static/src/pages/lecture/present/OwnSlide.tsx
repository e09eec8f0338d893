import "./ownSlide.css";
import { useEffect, useRef } from "preact/hooks";
import { act, canAct } from "./acts";
import { listenToKeys } from "./keys";
import { isPreview, paragraphsOf, place, presenting, slide } from "./state";

/** Lines that begin with a dash are a list. */
function Paragraph({ text, shown }: { text: string; shown: boolean }) {
  const lines = text.split("\n").filter((line) => line.trim());
  const isList = lines.every((line) => /^\s*[-–•] /.test(line));
  const style = { visibility: shown ? "visible" : "hidden" } as const;
  if (!isList) return <p style={style}>{text}</p>;
  return (
    <ul style={style}>
      {lines.map((line) => (
        <li key={line}>{line.replace(/^\s*[-–•] /, "")}</li>
      ))}
    </ul>
  );
}

/** A page of this service within the slide. Its window gives the keys of the presentation back. */
function Framed({ address, title }: { address: string; title: string }) {
  const frame = useRef<HTMLIFrameElement>(null);
  useEffect(() => {
    let stop = (): void => {};
    const listen = (): void => {
      stop();
      const inside = frame.current?.contentWindow;
      if (inside) stop = listenToKeys(inside, act, canAct);
    };
    const element = frame.current;
    element?.addEventListener("load", listen);
    return () => {
      element?.removeEventListener("load", listen);
      stop();
    };
  }, []);
  if (isPreview) return <p class="slide-frame-place">{address.split(/[?#]/)[0]}</p>;
  return <iframe class="slide-frame" src={address} title={title} ref={frame} />;
}

/** The present slide, where it is none of the lecture's. */
export function OwnSlide() {
  const now = slide.value;
  if (!presenting.value || !now || "section" in now) return null;
  return (
    <section class={`own-slide own-${now.kind} on-slide`} aria-label={now.title}>
      {now.kind === "text" ? (
        <>
          <h2>{now.title}</h2>
          {paragraphsOf(now.text).map((text, i) => (
            <Paragraph key={`${i} ${text}`} text={text} shown={i <= place.value.step} />
          ))}
        </>
      ) : (
        <Framed key={now.address} address={now.address} title={now.title} />
      )}
    </section>
  );
}
