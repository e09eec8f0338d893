import type { ComponentChildren } from "preact";
import { isDark } from "../../../ui/browser/theme";
import { Icon } from "../../../ui/Icon";

interface LogPictureProps {
  readonly id: string;
  readonly hasPicture: boolean;
  readonly isAwaited: boolean;
  readonly alt: string;
  /** What stands below the icon while there is no picture. */
  readonly children?: ComponentChildren;
}

/** The map of a log on its card, drawn by the server when it was read. */
export function LogPicture({ id, hasPicture, isAwaited, alt, children }: LogPictureProps) {
  return (
    <div class={`card-picture${isAwaited ? " awaited" : ""}`}>
      {hasPicture ? (
        <img
          src={`/api/logs/${encodeURIComponent(id)}/map.png?dark=${isDark.value}`}
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
