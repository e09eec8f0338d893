import { signal } from "@preact/signals";
import { NoReturn } from "../../lessons/noreturn/NoReturn";
import { Scrub } from "../../ui/Scrub";
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
            <b>Ignored</b>, the mapper’s first setting, never says what it does not know. <b>Taken for free</b> opens
            large halls quickly, and it is usually right; but drag the robot in front of the glass: the beams that went
            into it now swear that nothing is there. <b>The mistake</b> is a driver that writes the max range where
            there was no echo. The mapper cannot tell that number from a wall at just that distance, and builds one, all
            round. It offers the mistake as a setting of its own, so that you can recognise it in a map of yours.
          </p>
          <p>
            That is why REP 117 gives no return a value of its own: +∞. A log’s number at or beyond the sensor’s range
            is worth a look before it is believed.
          </p>
        </>
      }
    >
      <p>
        Some beams come back with nothing: the hall is larger than the sensor’s reach of{" "}
        <Scrub
          label="reach of the lidar"
          sentence="How far the lidar sees: what is farther away gives no return."
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
        or a surface swallowed the light. What does that say? The same four scans, taken in three ways. Drag the{" "}
        <b class="noun-robot">robot</b>.
      </p>
    </Section>
  );
}
