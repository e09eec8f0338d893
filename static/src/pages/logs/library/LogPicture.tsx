import type { ComponentChildren } from "preact";
import { isDark } from "../../../ui/browser/theme";
import { Icon } from "../../../ui/Icon";
import { addressOf } from "../../../wire/ask";

interface LogPictureProps {
  readonly id: string;
  readonly hasPicture: boolean;
  readonly isAwaited: boolean;
  readonly alt: string;
  /** Shown below the icon while there is no picture. */
  readonly children?: ComponentChildren;
}

/** The map of a log on its card, drawn by the server when it was read. */
export function LogPicture({ id, hasPicture, isAwaited, alt, children }: LogPictureProps) {
  return (
    <div class={`card-picture${isAwaited ? " awaited" : ""}`}>
      {hasPicture ? (
        <img
          src={addressOf("GET /api/logs/{log_id}/map.png", { log_id: id }, { dark: isDark.value })}
          alt={alt}
          loading="lazy"
          decoding="async"
        />
      ) : (
        <>
          <Icon name="map" />
          {children}
        </>
      )}
    </div>
  );
}
