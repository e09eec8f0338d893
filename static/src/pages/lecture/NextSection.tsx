import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

const PRODUCTION = [
  { name: "SLAM Toolbox", text: "drives once through the building: poses and map together" },
  { name: "map.pgm + map.yaml", text: "the saved map" },
  { name: "AMCL", text: "a particle filter that finds the robot on the map" },
  { name: "static layer", text: "the saved map in Nav2’s costmap" },
  { name: "obstacle layer", text: "the current scan on top of it" },
] as const;

export function NextSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="next" label="How the map is used in a robot with Nav2">
          <ol class="production">
            {PRODUCTION.map(({ name, text }) => (
              <li key={name}>
                <b>{name}</b>
                <span>{text}</span>
              </li>
            ))}
          </ol>
        </OnStage>
      }
      sources={[
        ["probabilistic-robotics", "chapters 4 and 9 for this lecture; chapters 8 and 13 for what follows"],
        ["octomap", ""],
        ["curless-levoy", ""],
      ]}
      after={
        <>
          <h3>With the map, and without known poses</h3>
          <p>
            <b>Monte Carlo localization</b> represents where the robot may be by a set of particles, weighs each by how
            well the scan fits the map, and draws again. <b>FastSLAM</b> gives every particle a map of its own;{" "}
            <b>grid-based SLAM</b> does this with occupancy grids. Graph-based SLAM, as in SLAM Toolbox, corrects all
            earlier poses when the robot comes back to a known place.
          </p>
          <h3>Other maps</h3>
          <p>
            <b>OctoMap</b> is the occupancy grid in three dimensions: a tree whose leaves are occupancy cells, in which
            one node stands for a large empty region. A <b>truncated signed distance field</b> (TSDF) stores the
            distance to the nearest surface and gives smooth surfaces. <b>Point clouds</b> keep the readings as they
            are, without free space. <b>Neural fields and Gaussian splats</b> are made to look at and are slow to
            update.
          </p>
        </>
      }
    >
      <p>
        In a robot with Nav2 the map passes through these parts. The saved map does not change any more; what moves is
        handled by the layer of the current scan.
      </p>
    </Section>
  );
}
