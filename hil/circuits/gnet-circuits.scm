;; Every part with its attributes and the net at each of its pins, one tab-separated line for each:
;; what the checks and the simulations of this folder are made from.
(use-modules (netlist schematic)
             (netlist schematic toplevel)
             (netlist package)
             (netlist package-pin))

(define (circuits output-filename)
  (for-each
   (lambda (part)
     (format #t "part\t~a\n" (package-refdes part))
     (for-each
      (lambda (attribute) (format #t "attribute\t~a\t~a\n" (car attribute) (cadr attribute)))
      (package-attribs part))
     (for-each
      (lambda (pin)
        (format #t "pin\t~a\t~a\t~a\n"
                (package-pin-number pin) (package-pin-label pin) (package-pin-name pin)))
      (package-pins part)))
   (schematic-packages (toplevel-schematic))))
