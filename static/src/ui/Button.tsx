import type { ComponentChildren } from "preact";
import { Icon } from "./Icon";
import type { IconName } from "./iconPaths";

interface ButtonProps {
  readonly onClick?: (event: MouseEvent) => void;
  readonly icon?: IconName;
  /** Accessible name and title of a button that shows only an icon. */
  readonly label?: string;
  readonly kind?: "primary" | "quiet" | "danger" | undefined;
  readonly size?: "large";
  readonly pressed?: boolean;
  readonly disabled?: boolean;
  /** With an address it is a link that looks like a button. */
  readonly href?: string;
  readonly download?: boolean | string;
  /** Of a link: a tab of its own. */
  readonly target?: "_blank";
  /** Whether it sends its form. */
  readonly submits?: boolean;
  readonly children?: ComponentChildren;
}

export function Button({
  onClick,
  icon,
  label,
  kind,
  size,
  pressed,
  disabled,
  href,
  download,
  target,
  submits = false,
  children,
}: ButtonProps) {
  const iconOnly = icon !== undefined && children === undefined;
  const className = ["button", kind, size, iconOnly && "icon-only"].filter(Boolean).join(" ");
  const inside = (
    <>
      {icon && <Icon name={icon} />}
      {children}
    </>
  );
  const name = label === undefined ? {} : { "aria-label": label, title: label };
  if (href !== undefined) {
    return (
      <a
        class={className}
        href={href}
        {...name}
        {...(download === undefined ? {} : { download })}
        {...(target === undefined ? {} : { target, rel: "noopener" })}
        {...(onClick ? { onClick } : {})}
      >
        {inside}
      </a>
    );
  }
  return (
    <button
      type={submits ? "submit" : "button"}
      class={className}
      {...name}
      {...(onClick ? { onClick } : {})}
      {...(pressed === undefined ? {} : { "aria-pressed": pressed })}
      disabled={disabled ?? false}
    >
      {inside}
    </button>
  );
}
