export interface Option {
  readonly value: string;
  readonly label: string;
}

interface SelectProps {
  /** The options, or names that are their own labels. */
  readonly options: readonly (Option | string)[];
  readonly value: string;
  readonly id?: string;
  /** The id of what describes it. */
  readonly describedBy?: string | undefined;
  /** For screen readers, where no label is beside it. */
  readonly label?: string | undefined;
  readonly disabled?: boolean | undefined;
  readonly class?: string;
  readonly onChange: (value: string) => void;
}

/** A menu of which one option is chosen. */
export function Select({ id, options, value, label, describedBy, disabled, class: more = "", onChange }: SelectProps) {
  return (
    <select
      id={id}
      class={`select ${more}`.trim()}
      aria-label={label}
      aria-describedby={describedBy}
      value={value}
      disabled={disabled}
      onChange={(event) => onChange(event.currentTarget.value)}
    >
      {options.map((one) => {
        const option = typeof one === "string" ? { value: one, label: one } : one;
        return (
          <option key={option.value} value={option.value} selected={option.value === value}>
            {option.label}
          </option>
        );
      })}
    </select>
  );
}

/** A menu below its label. */
export function SelectField({ title, ...props }: Omit<SelectProps, "label"> & { readonly title: string }) {
  return (
    <label class="field">
      <span class="field-label">{title}</span>
      <Select {...props} />
    </label>
  );
}
