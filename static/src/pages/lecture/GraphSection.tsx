import { Springs } from "../../lessons/graph/Springs";
import { Section, type SectionHead } from "./Section";

export function GraphSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Springs />}
      sources={[
        ["grisetti", ""],
        ["zhang", "for the kernels"],
        ["yang", "for a kernel whose scale shrinks while the graph is solved"],
        ["kuemmerle", "for how the result is judged"],
      ]}
      after={
        <>
          <p>
            The solution is the pose of every node with the least sum of squared residuals, each in standard deviations,
            eᵀ Ω e. Plain least squares follow the <b class="noun-hit">wrong loop</b>: it is only one spring among many,
            but its residual is large, and it distorts the map. A <b>robust kernel</b> reduces the weight of loops with
            large residuals, as the curve shows, so the others determine the result. Its scale is large at first, so
            that no loop is rejected, and shrinks while the graph is solved. A kernel cannot tell a wrong loop that
            nothing contradicts from a right one.
          </p>
          <p>
            “Heal” on the page of a log whose poses drift does this: each scan is matched with those before it, loops
            are found by correlative matching, and the graph of all poses is solved.
          </p>
        </>
      }
    >
      <p>
        A matcher corrects one pose and leaves the earlier ones as they are. In a <b>pose graph</b> all of them are
        corrected together. Its nodes are poses; each measured motion between two of them is a spring, which is at rest
        where the poses agree with the measurement. The odometry makes a chain. Where the robot comes back to a place,
        the scans match, and a <b>loop</b> joins two nodes that are far apart in the chain: the error is spread over all
        springs between. Drag a pose and let it go, then close the loop.
      </p>
    </Section>
  );
}
