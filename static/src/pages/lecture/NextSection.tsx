import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

const KINDS = [
  {
    name: "Octree of cells (OctoMap)",
    keeps: "occupied, free and unknown in 3D",
    gives: "time: each update descends a tree",
  },
  {
    name: "Signed distance (TSDF)",
    keeps: "the distance to the nearest surface, smooth",
    gives: "space far from surfaces: only a band is kept",
  },
  { name: "Point cloud", keeps: "the readings as they are", gives: "free space: where no point is, nothing is known" },
  { name: "Gaussian splats", keeps: "the look of a place from any side", gives: "free space, and quick updates" },
  { name: "Neural field", keeps: "look or shape in the weights of a network", gives: "quick updates: it is trained" },
] as const;

export function NextSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="next" label="Other kinds of maps">
          <table class="plain-table">
            <thead>
              <tr>
                <th scope="col">map</th>
                <th scope="col">keeps</th>
                <th scope="col">gives up</th>
              </tr>
            </thead>
            <tbody>
              {KINDS.map(({ name, keeps, gives }) => (
                <tr key={name}>
                  <th scope="row">{name}</th>
                  <td>{keeps}</td>
                  <td>{gives}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </OnStage>
      }
      sources={[
        ["probabilistic-robotics", "chapters 4 and 9 for this lecture; chapters 8 and 13 for what follows"],
        ["octomap", ""],
        ["curless-levoy", ""],
        ["kerbl", ""],
        ["mildenhall", ""],
      ]}
      after={
        <>
          <h3>Poses and map together</h3>
          <p>
            <b>FastSLAM</b> gives every particle a map of its own; <b>grid-based SLAM</b> does this with occupancy
            grids. Graph-based SLAM, as in SLAM Toolbox, corrects all earlier poses when the robot comes back to a known
            place.
          </p>
        </>
      }
    >
      <p>
        An occupancy grid on a plane is one of several maps. Each of the others stores something that it does not, and
        lacks something that it has. A planner needs <b>free space</b>: from a map without it one cannot tell where a
        robot may drive.
      </p>
    </Section>
  );
}
