import { Prediction } from "../../lessons/common/Prediction";
import { FIRST_PLACE, withoutReturn } from "../../lessons/noreturn/model";
import { NoReturn, robotAt } from "../../lessons/noreturn/NoReturn";
import { noReturn, noReturnRange as rangeMax } from "../../lessons/stage/controls";
import { Choice } from "../../ui/Choice";
import { DragNumber } from "../../ui/DragNumber";
import { Section, type SectionHead } from "./Section";

const POLICIES = [
  { value: "ignore", label: "ignored" },
  { value: "free", label: "free" },
  { value: "hit", label: "a hit" },
];

export function NoReturnSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
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
          reveal={() => {
            robotAt.value = FIRST_PLACE;
            rangeMax.value = 5;
            return withoutReturn(FIRST_PLACE, 5);
          }}
        />
      }
      sources={[
        ["rep-117", ""],
        ["probabilistic-robotics", "table 9.2; chapter 6 for what else a reading can be"],
      ]}
      after={
        <>
          <p>
            What is right? <b>Table 9.2</b> of <cite>Probabilistic Robotics</cite> takes no return <b>as free</b>: the
            reading is z_max, so all cells up to z_max are free, and none is occupied. This clears large halls quickly
            and is usually correct; but drag the robot in front of the glass: the beams that pass through it mark the
            glass as free. <b>Ignored</b> adds no evidence, and is the default of this mapper in the lecture, in the lab
            and for logs. The reason: in recorded logs a missing return often means glass, a polished wall, black
            material or a reading that the driver filtered out, and free space that is wrong is the more dangerous
            error. <b>Taken as a hit</b> is an error: it happens when a driver writes the max range where there was no
            echo. The mapper cannot distinguish that number from a wall at the same distance, and marks a wall at that
            distance. It offers this error as a setting, so that you can recognise it in your own maps.
          </p>
          <p>
            For this reason REP 117 defines a separate value for no return: +∞. Check the readings of a log that are at
            or beyond the sensor’s max range before you use them.
          </p>
        </>
      }
    >
      <p>
        Some beams have no return: the hall is larger than the sensor’s max range of{" "}
        <DragNumber
          label="max range, lidar"
          sentence="Surfaces that are farther away give no return."
          value={rangeMax.value}
          unit="m"
          tone="beam"
          low={1}
          high={9}
          step={0.1}
          onInput={(value) => {
            rangeMax.value = value;
          }}
          after=","
        />{" "}
        or a surface did not reflect the light back. The range is this short so that the figure shows it; the mapper’s
        default is 30 m. What does no return mean for the map? The figure shows the same four scans, interpreted in
        three ways. Drag the <b class="noun-robot">robot</b>.
      </p>
    </Section>
  );
}
