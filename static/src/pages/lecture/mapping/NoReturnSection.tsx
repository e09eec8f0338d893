import { Prediction } from "../../../lessons/common/Prediction";
import { FIRST_PLACE, withoutReturn } from "../../../lessons/noreturn/model";
import { NoReturn, robotAt } from "../../../lessons/noreturn/NoReturn";
import { noReturn, noReturnRange as rangeMax } from "../../../lessons/stage/controls";
import { bound } from "../../../ui/bound";
import { Choice } from "../../../ui/Choice";
import { DragNumber } from "../../../ui/DragNumber";
import { Section, type SectionHead } from "../Section";

const POLICIES = [
  { value: "ignore", label: "ignored" },
  { value: "free", label: "free" },
  { value: "hit", label: "a hit" },
];

export function NoReturnSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <>
          <NoReturn rangeMax={rangeMax} />
          <div class="for-stage no-print">
            <Choice
              label="On the stage: no return is"
              options={POLICIES}
              value={noReturn.value}
              onChange={(value) => {
                noReturn.value = value === "free" || value === "hit" ? value : "ignore";
              }}
            />
          </div>
        </>
      }
      predict={
        <Prediction
          text="The robot is back at its first place, and the max range is raised from 3 m to 5 m. How many of the 180 beams have no return?"
          axis={{ low: 0, high: 180, unit: "beams" }}
          step={1}
          because="These beams meet glass, or nothing within 5 m."
          reveal={() => {
            robotAt.value = FIRST_PLACE;
            rangeMax.value = 5;
            return withoutReturn(FIRST_PLACE, 5);
          }}
        />
      }
      sources={["rep-117", ["probabilistic-robotics", "chapter 6 and table 9.2"]]}
      after={
        <>
          <p>
            Which is right depends on why nothing came back. <b>Free</b> is what table 9.2 of{" "}
            <cite>Probabilistic Robotics</cite> says: the reading is <i>z</i>
            <sub>max</sub>, so all cells up to it are free. That clears large halls, but erases glass once the beams
            pass through it. <b>Ignored</b> adds no evidence and is safer: a missing return often means glass, a
            polished wall or black material. Counting no return as a <b>hit</b> is always wrong; it happens when a
            driver reports the max range where there was no echo.
          </p>
          <p>REP 117, a convention of ROS, therefore defines +∞ for no return.</p>
        </>
      }
    >
      <p>
        Some beams have no return: the hall is larger than the sensor’s max range of{" "}
        <DragNumber
          label="max range, lidar"
          sentence="Surfaces that are farther away give no return."
          {...bound(rangeMax)}
          unit="m"
          tone="beam"
          low={1}
          high={9}
          step={0.1}
          after=","
        />{" "}
        or a surface did not reflect the light back. The figure shows the same four scans, interpreted in three ways.{" "}
        <span class="no-print">
          Drag the <b class="noun-robot">robot</b> in front of the glass.
        </span>
      </p>
    </Section>
  );
}
