import { computed } from "@preact/signals";
import { tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import { isDark } from "../../ui/theme";

/** A colour token with an opacity, as a CSS colour. */
const ink = (token: `--${string}`, alpha = 1): string => {
  const [red, green, blue] = tokenRgb(token);
  return `rgb(${red} ${green} ${blue} / ${alpha})`;
};

/** Shades in which the values of points and edges are told apart. */
export const SHADES = 16;

/** The colours of the shades, from little to much. */
function shades(): readonly string[] {
  const [low, high] = [toLab(tokenRgb("--miss")), toLab(tokenRgb("--hit"))];
  return Array.from({ length: SHADES }, (_, i) => `rgb(${fromLab(mixed(low, high, i / (SHADES - 1))).join(" ")})`);
}

/** The colours of the pictures in the current theme. */
export const inks = computed(() => {
  void isDark.value;
  return {
    floor: ink("--surface"),
    outside: ink("--surface-sunk"),
    solid: ink("--map-solid"),
    ink: ink("--ink"),
    halo: ink("--surface", 0.85),
    beam: ink("--beam"),
    beamFill: ink("--beam-fill"),
    robot: ink("--robot"),
    robotFill: ink("--robot-fill"),
    hit: ink("--hit"),
    miss: ink("--miss"),
    prior: ink("--prior"),
    trail: ink("--robot", 0.7),
    shades: shades(),
  };
});

export type Inks = typeof inks.value;
