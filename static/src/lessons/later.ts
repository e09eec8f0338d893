/** What is built on the map: the scenes and figures that the lecture fetches after its first sections. */

import { Kidnapping } from "./localization/Kidnapping";
import { Particles } from "./localization/Particles";
import { SensorModels } from "./localization/SensorModels";
import { kidnappingScene, particlesScene, sensorScene } from "./localization/scenes";
import type { Later, LaterId } from "./stage/later";

export const LATER: Readonly<Record<LaterId, Later>> = {
  particles: { scene: particlesScene, figure: Particles },
  "sensor-models": { scene: sensorScene, figure: SensorModels },
  kidnapping: { scene: kidnappingScene, figure: Kidnapping },
};
