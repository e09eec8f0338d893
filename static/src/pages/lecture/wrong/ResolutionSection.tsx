import { Prediction } from "../../../lessons/common/Prediction";
import { sizeOf } from "../../../lessons/resolution/model";
import { Resolution } from "../../../lessons/resolution/Resolution";
import { Section, type SectionHead } from "../Section";

export function ResolutionSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<Resolution />}
      predict={
        <Prediction
          text="The floor takes 154 kB in cells of 5 cm. How much memory does it take in cells of 2 cm?"
          axis={{ low: 0, high: 4000, unit: "kB" }}
          step={10}
          because="The same area has (5/2)² = 6.25 times as many cells."
          reveal={() => sizeOf(0.02).bytes / 1000}
        />
      }
      sources={["occupancy-grid"]}
      after={
        <p>
          Halving the side makes four times as many cells, and each beam crosses twice as many. Cells of 1 cm show the
          noise of the sensor; in cells of 10 cm a door of 80 cm may lose a quarter of its width. <b>5 cm</b> is usual
          in buildings.
        </p>
      }
    >
      <p>
        How large should a cell be? The figure shows the same scans of a door and a pillar in cells of 1, 5 and 10 cm.
      </p>
    </Section>
  );
}
