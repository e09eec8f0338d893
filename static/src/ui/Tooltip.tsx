import { useRef } from "preact/hooks";
import { zoomOf } from "./browser/useSize";
import { Icon } from "./Icon";

interface TooltipProps {
  readonly text: string;
  readonly about: string;
  /** The sentence's id, for a control that is described by it. */
  readonly id: string;
}

/** An info icon that shows a sentence on hover, focus and tap. */
export function Tooltip({ text, about, id }: TooltipProps) {
  const tip = useRef<HTMLSpanElement>(null);
  const button = useRef<HTMLButtonElement>(null);

  const show = (): void => {
    const box = tip.current;
    const anchor = button.current?.getBoundingClientRect();
    if (!box || !anchor || box.matches(":popover-open")) return;
    box.showPopover();
    button.current?.setAttribute("aria-expanded", "true");
    const { width, height } = box.getBoundingClientRect();
    const zoom = zoomOf(box);
    const left = Math.min(innerWidth - width - 12, Math.max(12, anchor.left + anchor.width / 2 - width / 2));
    const above = anchor.top - height - 6;
    box.style.left = `${left / zoom}px`;
    box.style.top = `${(above > 8 ? above : anchor.bottom + 6) / zoom}px`;
  };
  const hide = (): void => {
    if (tip.current?.matches(":popover-open")) tip.current.hidePopover();
    button.current?.setAttribute("aria-expanded", "false");
  };

  return (
    <>
      <button
        ref={button}
        type="button"
        class="tip-button"
        aria-label={`About ${about}`}
        aria-describedby={id}
        aria-expanded="false"
        onPointerEnter={show}
        onPointerLeave={hide}
        onFocus={show}
        onBlur={hide}
        onClick={show}
        onKeyDown={(event) => event.key === "Escape" && hide()}
      >
        <Icon name="info" />
      </button>
      <span ref={tip} id={id} class="tip" popover="manual" role="tooltip">
        {text}
      </span>
    </>
  );
}
