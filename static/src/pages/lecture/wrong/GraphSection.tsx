import { Springs } from "../../../lessons/graph/Springs";
import { Section, type SectionHead } from "../Section";

export function GraphSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<Springs />}
      sources={["grisetti", ["zhang", "(kernels)"], ["yang", "(shrinking scale)"], ["kuemmerle", "(evaluation)"]]}
      after={
        <p>
          The solution has the least sum of eᵀ Ω e over the springs: e is the residual of a spring, Ω the inverse of its
          covariance, so that residuals count in standard deviations. A least-squares solution follows the{" "}
          <b class="noun-hit">wrong loop</b>: its residual is large, and it distorts the map. A <b>robust kernel</b>{" "}
          reduces the weight <i>w</i> of loops with large residuals in this sum, but cannot tell a wrong loop that
          nothing contradicts from a right one.
        </p>
      }
    >
      <p>
        A matcher corrects one pose and leaves the earlier ones; a <b>pose graph</b> corrects all together. Its nodes
        are poses; each measured motion between two of them is a spring, at rest where the poses agree with it. The
        odometry makes a chain: nothing contradicts it, so all springs are at rest, however wrong it is. Where the robot
        comes back to a place, a <b>loop</b> joins two nodes far apart.{" "}
        <span class="no-print">Drag a pose and let it go, then close the loop.</span>
      </p>
    </Section>
  );
}
