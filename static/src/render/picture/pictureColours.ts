import { computed } from "@preact/signals";
import { tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import { isDark } from "../../ui/browser/theme";

/** A colour token with an opacity, as a CSS colour. */
const colourOf = (token: `--${string}`, alpha = 1): string => {
  const [red, green, blue] = tokenRgb(token);
  return `rgb(${red} ${green} ${blue} / ${alpha})`;
};

/** Number of shades for the values of points and edges. */
export const SHADES = 16;

/** The colours of the shades, from the smallest value to the largest. */
function shades(): readonly string[] {
  const [low, high] = [toLab(tokenRgb("--miss")), toLab(tokenRgb("--hit"))];
  return Array.from({ length: SHADES }, (_, i) => `rgb(${fromLab(mixed(low, high, i / (SHADES - 1))).join(" ")})`);
}

/** The colours of the pictures in the current theme. */
export const pictureColours = computed(() => {
  void isDark.value;
  return {
    floor: colourOf("--surface"),
    outside: colourOf("--surface-sunken"),
    solid: colourOf("--map-solid"),
    outline: colourOf("--foreground"),
    halo: colourOf("--surface", 0.85),
    beam: colourOf("--beam"),
    beamFill: colourOf("--beam-fill"),
    robot: colourOf("--robot"),
    robotFill: colourOf("--robot-fill"),
    hit: colourOf("--hit"),
    miss: colourOf("--miss"),
    speedLimit: colourOf("--speed-limit"),
    prior: colourOf("--prior"),
    trail: colourOf("--robot", 0.7),
    shades: shades(),
  };
});

export type PictureColours = typeof pictureColours.value;
