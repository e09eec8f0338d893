import { mapKind } from "../../../lessons/stage/controls";
import { Choice } from "../../../ui/Choice";
import { OnStage, Section, type SectionHead } from "../Section";

const KINDS = [
  { value: "corners", label: "landmarks" },
  { value: "grid", label: "grid" },
];

export function LandmarksSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="landmarks" label="The same drive as a map of landmarks and as a grid">
          <Choice
            label="The map as"
            options={KINDS}
            value={mapKind.value}
            onChange={(value) => {
              mapKind.value = value === "grid" ? "grid" : "corners";
            }}
          />
          <div class="table-room">
            <table class="plain-table">
              <thead>
                <tr>
                  <td />
                  <th scope="col">Landmarks</th>
                  <th scope="col">Grid</th>
                </tr>
              </thead>
              <tbody>
                <tr>
                  <th scope="row">needs</th>
                  <td>a detector that finds the same landmark again</td>
                  <td>no detector; every reading is used</td>
                </tr>
                <tr>
                  <th scope="row">stores</th>
                  <td>position of each landmark and how uncertain it is: few numbers</td>
                  <td>one number per cell: grows with the area</td>
                </tr>
                <tr>
                  <th scope="row">another reading</th>
                  <td>improves the estimate of its position</td>
                  <td>adds evidence for each cell that it touches</td>
                </tr>
                <tr>
                  <th scope="row">gives</th>
                  <td>where the robot is, relative to the landmarks</td>
                  <td>where it can drive: free space, walls of any shape, and what is still unknown</td>
                </tr>
              </tbody>
            </table>
          </div>
        </OnStage>
      }
      sources={[["probabilistic-robotics", "chapters 6, 7 and 9"]]}
      after={
        <p>
          A grid is <b>non-parametric</b>: it assumes neither the shape nor the number of objects. Nav2, the navigation
          software of ROS 2, plans on two-dimensional grids.
        </p>
      }
    >
      <p>
        A robot in an unknown building asks two questions: where am I, and where can I drive? A map of{" "}
        <b class="noun-beam">landmarks</b> stores the positions of things that are easy to recognise, such as corners.
        An <b>occupancy grid</b> stores, for every small square of the floor, whether something is there.{" "}
        <span class="no-print">Switch between the two maps of one drive.</span>
      </p>
    </Section>
  );
}
