import { signal } from "@preact/signals";
import { NoReturn } from "../../lessons/noreturn/NoReturn";
import { DragNumber } from "../../ui/DragNumber";
import { Section } from "./Section";

const rangeMax = signal(3);

export function NoReturnSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<NoReturn rangeMax={rangeMax} />}
      sources={[
        ["rep-117", ""],
        ["probabilistic-robotics", "section 6.3, for what else a reading can be"],
      ]}
      after={
        <>
          <p>
            <b>Ignored</b>, the mapper’s default, adds no evidence. <b>Taken as free</b> clears large halls quickly and
            is usually correct; but drag the robot in front of the glass: the beams that pass through it mark the glass
            as free. <b>Taken as a hit</b> is an error: it happens when a driver writes the max range where there was no
            echo. The mapper cannot distinguish that number from a wall at the same distance, and marks a wall all
            around. It offers this error as a setting, so that you can recognise it in your own maps.
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
        or a surface did not reflect the light back. What does that mean for the map? The figure shows the same four
        scans, interpreted in three ways. Drag the <b class="noun-robot">robot</b>.
      </p>
    </Section>
  );
}
