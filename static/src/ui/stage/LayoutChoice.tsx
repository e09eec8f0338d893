import type { Signal } from "@preact/signals";
import { Icon } from "../Icon";
import type { IconName } from "../iconPaths";
import { Select } from "../Select";
import { ARRANGEMENTS, type Arrangement, arranged, type Layout, written } from "./layout";
import "./stage.css";

const LABELS: Readonly<Record<Arrangement, readonly [icon: IconName, label: string]>> = {
  one: ["viewOne", "One view (1)"],
  beside: ["viewsBeside", "Two views beside each other (2)"],
  above: ["viewsAbove", "Two views above each other (3)"],
  four: ["viewsFour", "Four views (4)"],
};

/** A layout to begin with, and its name. */
export type Preset = readonly [name: string, layout: Layout];

interface LayoutChoiceProps {
  readonly layout: Signal<Layout>;
  /** The kinds of views that there are. */
  readonly kinds: readonly string[];
  /** Those are offered whose views there are. */
  readonly presets: readonly Preset[];
}

/** The arrangements of the stage as buttons, and layouts to begin with. */
export function LayoutChoice({ layout, kinds, presets }: LayoutChoiceProps) {
  const now = layout.value;
  const names = presets.filter(([, preset]) => preset.views.every((view) => kinds.includes(view)));
  const chosen = names.find(
    ([, preset]) => preset.arrangement === now.arrangement && `${preset.views}` === `${now.views}`,
  );
  return (
    <div class="layout-choice" role="toolbar" aria-label="Layout of the views">
      <Select
        label="Layout"
        value={chosen ? written(chosen[1]) : ""}
        options={[
          ...(chosen ? [] : [{ value: "", label: "Own layout" }]),
          ...names.map(([name, preset]) => ({ value: written(preset), label: name })),
        ]}
        onChange={(value) => {
          const entry = names.find(([, preset]) => written(preset) === value);
          if (entry) layout.value = entry[1];
        }}
      />
      {ARRANGEMENTS.map((arrangement) => {
        const [icon, label] = LABELS[arrangement];
        return (
          <button
            key={arrangement}
            type="button"
            class="button quiet icon-only"
            aria-label={label}
            title={label}
            aria-pressed={now.arrangement === arrangement}
            onClick={() => {
              layout.value = arranged(now, arrangement, kinds);
            }}
          >
            <Icon name={icon} />
          </button>
        );
      })}
    </div>
  );
}
