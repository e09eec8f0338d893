import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Button } from "../../ui/Button";
import { OpenFiles } from "../../ui/files/OpenFiles";
import { saveAs } from "../../ui/files/saveAs";
import { ask, fileOf } from "../../wire/ask";
import type { AmclParameters } from "../../wire/http";
import type { Values } from "../../wire/protocol";
import "./localization.css";

interface AmclYamlProps {
  /** The values to save. */
  readonly values: () => Values;
  readonly onOpen: (values: Values) => void;
}

/** The parameters of localization, read from and written to an AMCL yaml file. */
export function AmclYaml({ values, onOpen }: AmclYamlProps) {
  const opened = useRef<Omit<AmclParameters, "values" | "notes">>({ layout: "nav2", others: {} });
  const said = useSignal<{ readonly text: string; readonly isError: boolean } | null>(null);
  const doing = async (what: () => Promise<string | null>): Promise<void> => {
    try {
      const text = await what();
      said.value = text === null ? null : { text, isError: false };
    } catch (error) {
      said.value = { text: (error as Error).message, isError: true };
    }
  };
  const open = (file: File): Promise<void> =>
    doing(async () => {
      const { values: loaded, notes, ...rest } = await readAmclYaml(file);
      opened.current = rest;
      onOpen(loaded);
      const kept = Object.keys(rest.others);
      const count = Object.keys(loaded).length;
      const set = `${count} ${count === 1 ? "parameter differs" : "parameters differ"} from the first values.`;
      const without = kept.length > 0 ? [`Without effect here, and kept where you save: ${kept.join(", ")}.`] : [];
      return [set, ...without, ...notes].join(" ");
    });
  const save = (): Promise<void> =>
    doing(async () => {
      saveAs("amcl.yaml", await amclYaml({ ...opened.current, values: values() }));
      return null;
    });
  return (
    <div class="localization-row">
      <OpenFiles kind="quiet" label="Yaml of an AMCL" accept=".yaml,.yml" onFiles={([file]) => void open(file)}>
        Open an AMCL yaml
      </OpenFiles>
      <Button kind="quiet" icon="download" onClick={() => void save()}>
        Save as AMCL yaml
      </Button>
      {said.value && <p role={said.value.isError ? "alert" : "status"}>{said.value.text}</p>}
    </div>
  );
}

export type { AmclParameters };

const readAmclYaml = (file: File): Promise<AmclParameters> =>
  ask("PUT /api/localization/parameters", {}, { body: file });

/** Parameters as an AMCL yaml file. */
async function amclYaml({ values, layout, others }: Omit<AmclParameters, "notes">): Promise<Blob> {
  const options = { query: { layout }, body: { ...others, ...values } };
  return (await fileOf("POST /api/localization/amcl.yaml", {}, options)).blob();
}
