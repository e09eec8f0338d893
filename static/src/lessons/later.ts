/** What is built on the map: the scenes and figures that the lecture fetches after its first sections. */

import { Kidnapping } from "./localization/Kidnapping";
import { ParticleNumber } from "./localization/ParticleNumber";
import { Particles } from "./localization/Particles";
import { SensorModels } from "./localization/SensorModels";
import { kidnappingScene, particlesScene, sensorScene } from "./localization/scenes";
import { InflationCurve, Layers } from "./navigation/Layers";
import { Lifetime } from "./navigation/Lifetime";
import { PathControls } from "./navigation/PathControls";
import { Stack, stackScene } from "./navigation/Stack";
import { inflationScene, layersScene, lifetimeScene, pathScene } from "./navigation/scenes";
import { Octree, octreeScene } from "./octree/Octree";
import type { Later, LaterId } from "./stage/later";
import { Tsdf, tsdfScene } from "./tsdf/Tsdf";

export const LATER: Readonly<Record<LaterId, Later>> = {
  particles: { scene: particlesScene, figure: Particles, more: ParticleNumber },
  "sensor-models": { scene: sensorScene, figure: SensorModels },
  kidnapping: { scene: kidnappingScene, figure: Kidnapping },
  layers: { scene: layersScene, figure: Layers },
  inflation: { scene: inflationScene, figure: InflationCurve },
  path: { scene: pathScene, figure: PathControls },
  lifetime: { scene: lifetimeScene, figure: Lifetime },
  stack: { scene: stackScene, figure: Stack },
  octree: { scene: octreeScene, figure: Octree },
  tsdf: { scene: tsdfScene, figure: Tsdf },
};
