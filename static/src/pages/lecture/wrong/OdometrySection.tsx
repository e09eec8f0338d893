import { signal } from "@preact/signals";
import { Prediction } from "../../../lessons/common/Prediction";
import { Drift } from "../../../lessons/odometry/Drift";
import { byOdometry, errorOf, USUAL } from "../../../lessons/odometry/model";
import { driftError } from "../../../lessons/stage/controls";
import { bound } from "../../../ui/bound";
import { DragNumber } from "../../../ui/DragNumber";
import { Slider } from "../../../ui/Slider";
import { Section, type SectionHead, SectionLink } from "../Section";

const noise = signal(USUAL);
const DEGREE = Math.PI / 180;
/** The noise in the question. */
const TWICE = { ...USUAL, turn: 2 * USUAL.turn };

export function OdometrySection(head: SectionHead) {
  const { way, turn } = noise.value;
  return (
    <Section
      {...head}
      figure={
        <>
          <Drift noise={noise} />
          <div class="for-stage no-print">
            <Slider
              label="On the stage: heading error"
              sentence="By how much the heading of the stage’s robot is off after each scan, added up."
              {...bound(driftError)}
              initial={0.15}
              low={-1}
              high={1}
              step={0.05}
              unit="° per scan"
              tone="hit"
            />
          </div>
        </>
      }
      predict={
        <Prediction
          text="The heading error is doubled to 8° per metre. How far off are the odometry poses then?"
          axis={{ low: 0, high: 6, unit: "m" }}
          step={0.1}
          reveal={() => {
            noise.value = TWICE;
            return errorOf(byOdometry(TWICE));
          }}
        />
      }
      sources={[["probabilistic-robotics", "chapter 5"]]}
      after={
        <p>
          Errors of the heading matter most: they rotate all of the path that follows. Between two scans the lidar is
          more accurate than the wheels; for the right map each scan was matched with the three before it. Small errors
          remain and add up slowly; <SectionLink to="graph" /> spreads them over the whole lap.
        </p>
      }
    >
      <p>
        So far every pose was given. Wheels slip, and the errors of odometry add up: after one lap the same wall is in
        several places. Each metre driven adds an error of{" "}
        <DragNumber
          label="Heading error"
          sentence="Standard deviation for each metre driven."
          value={Math.round((10 * turn) / DEGREE) / 10}
          text={`${Math.round((10 * turn) / DEGREE) / 10}°`}
          tone="hit"
          low={0}
          high={12}
          step={0.5}
          onInput={(value) => {
            noise.value = { ...noise.peek(), turn: value * DEGREE };
          }}
        />{" "}
        to the heading and of{" "}
        <DragNumber
          label="Distance error"
          sentence="Standard deviation for each metre driven."
          value={Math.round(100 * way)}
          text={`${Math.round(100 * way)} %`}
          tone="hit"
          low={0}
          high={30}
          step={1}
          onInput={(value) => {
            noise.value = { ...noise.peek(), way: value / 100 };
          }}
        />{" "}
        to the distance (standard deviations).
      </p>
    </Section>
  );
}
