import { Prediction } from "../../lessons/common/Prediction";
import { sizeOf } from "../../lessons/resolution/model";
import { Resolution } from "../../lessons/resolution/Resolution";
import { Section, type SectionHead } from "./Section";

export function ResolutionSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Resolution />}
      predict={
        <Prediction
          text="The floor takes 154 kB in cells of 5 cm. How much memory does it take in cells of 2 cm?"
          axis={{ low: 0, high: 4000, unit: "kB" }}
          step={10}
          reveal={() => sizeOf(0.02).bytes / 1000}
        />
      }
      sources={[["occupancy-grid", ""]]}
      after={
        <p>
          Halving the side of a cell makes four times as many cells, and each beam crosses twice as many of them. Cells
          of 1 cm show the noise of the sensor instead of the wall; in cells of 10 cm a door of 80 cm may lose a quarter
          of its width. <b>5 cm</b> is the usual choice for robots in buildings, and the default of this mapper.
        </p>
      }
    >
      <p>
        How large should a cell be? The figure shows the same scans of the door and the pillar in cells of 1, 5 and 10
        cm. The memory is that of the whole floor of 12 × 8 m with four bytes per cell. The time is measured on your
        computer when the maps are made.
      </p>
    </Section>
  );
}
