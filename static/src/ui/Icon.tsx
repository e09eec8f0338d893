import { ICON_PATHS, type IconName } from "./iconPaths";

/** A line icon, 24 × 24, in the colour of the surrounding text. */
export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 24 24" aria-hidden="true" focusable="false">
      <path d={ICON_PATHS[name]} />
    </svg>
  );
}
