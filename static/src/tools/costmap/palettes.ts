/** The palettes of costs and of the potential: alone on a sheet, and drawn over the belief. */

import { costColours, potentialColours, speedColours } from "../../render/map/costColours";
import { PALETTES, type Palette } from "../../render/map/palettes";

export const COSTS_OVER: Palette = {
  key: "costs over",
  colours: () => costColours(true),
};
export const COSTS: Palette = { key: "costs", colours: () => costColours(false) };
export const POTENTIAL_OVER: Palette = { key: "potential over", colours: potentialColours };
export const SPEED_OVER: Palette = { key: "speed over", colours: speedColours };

PALETTES.costs = () => COSTS;
PALETTES.potential = () => POTENTIAL_OVER;
PALETTES.speed = () => SPEED_OVER;
